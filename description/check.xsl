<?xml version="1.0" encoding="UTF-8"?>
<!-- SPDX-License-Identifier: BSD-2-Clause -->
<!--
  The check of a system description in XSLT 1.0, for tool chains that have nothing but XML:

      xsltproc -xinclude check.xsl system.xml

  It finds what the MLCCA paper calls completeness and correctness, under the same numbers as
  "mlccactl check":
    MLCCA010  a subscription has no publisher
    MLCCA020  a publisher does not offer the traffic that a subscriber asks of it
    MLCCA021  a network or gateway of the connection does not fulfil what the two ask together
    MLCCA034  a note: what a CAN bus or a mesh gives is computed, and is not decided here; nor is what
              all channels together need of a Bandwidth, what the hops of a Route give together, and
              what is said once for every description: identifiers, frames, and others who receive
    MLCCA038 to MLCCA041  notes on what is hardly meant
  The connection is the network that both sit on, or the Route that is declared between their
  places. Left to "mlccactl check": routes as a whole, subscribers that overhear the events, capacity, bindings,
  frame lengths, and connections that are not declared (said in a note).

  Output: a line for each finding, in the order of channels, their publishers and subscribers, then
  the notes, and last the line "N findings", since an exit status cannot tell. With
  -stringparam format xml: Findings/Finding, with names and numbers in attributes and the line as
  text, and Findings/Left, Findings/Undecided or Findings/Note for a note.

  - A description is taken for valid: "xmllint -xinclude -nofixup-base-uris -schema system.xsd" holds
    it against the schema, and "mlccactl check" knows the other rules. Names that lead nowhere
    (MLCCA005) and an xi:include that was not carried out (MLCCA001) are findings here all the same:
    what they hide would not be checked.
  - An attribute may be an element or an XML attribute: period="50ms" is the Attribute Period.
  - Values are whole numbers of 20 digits in the unit of the table below, kept as strings: XSLT has
    only floating point, which would round them. They are cut or rounded up from the decimal as
    everywhere: a requirement towards harder, a provision towards worse.
  - A best case (dynamic) refutes like any other value. That it cannot grant is for the run time.
  - An event of several CAN frames (FAMOUSO fragments): a bound above 0 on lost frames bounds no
    events. Its PacketLoss, which is larger than that of a frame, is taken for a best case.
  - Of a channel's attribute sets the first, by priority, in which nothing is found counts. If there
    is none, the findings are those of the preferred set, unless a lower one may serve somebody: then
    mlccactl check may use that, and a note says so.
-->
<xsl:stylesheet version="1.0" xmlns:xsl="http://www.w3.org/1999/XSL/Transform"
                xmlns:xi="http://www.w3.org/2001/XInclude" xmlns:t="urn:mlcca:table"
                exclude-result-prefixes="t xi">
  <!-- The method is not text, which cannot write format xml. No line has characters that XML escapes. -->
  <xsl:output method="xml" omit-xml-declaration="yes" encoding="UTF-8"/>
  <xsl:param name="format" select="'text'"/>

  <!--
    The attributes of include/mlcca/attribute.hpp. scale: integer units in one SI unit, as a power of
    ten. traffic: the attribute may be required of the publisher's traffic, and which values are better
    there (a subscriber's MaxPayload is the most that it accepts). of-networks: a gateway limits it only
    if it states it.
  -->
  <t:attribute name="Latency" scale="9" unit="ns" better="smaller"/>
  <t:attribute name="Jitter" scale="9" unit="ns" better="smaller" traffic="smaller"/>
  <t:attribute name="Deadline" scale="9" unit="ns" better="smaller"/>
  <t:attribute name="Period" scale="9" unit="ns" better="smaller" traffic="smaller" of-networks="yes"/>
  <t:attribute name="Bandwidth" scale="0" unit="bytes/s" better="larger" traffic="larger" of-networks="yes"/>
  <t:attribute name="PacketLoss" scale="9" unit="x 1e-9" better="smaller"/>
  <t:attribute name="Omission" scale="0" unit="events" better="smaller"/>
  <t:attribute name="MaxPayload" scale="0" unit="bytes" better="larger" traffic="smaller" of-networks="yes"/>

  <!-- The units of XML attributes, as in system.xsd: powers of ten of the SI unit. -->
  <t:unit name="s" power="0"/>
  <t:unit name="ms" power="-3"/>
  <t:unit name="us" power="-6"/>
  <t:unit name="ns" power="-9"/>
  <t:unit name="kB/s" power="3"/>
  <t:unit name="MB/s" power="6"/>
  <t:unit name="GB/s" power="9"/>
  <t:unit name="%" power="-2"/>
  <t:unit name="ppm" power="-6"/>
  <t:unit name="ppb" power="-9"/>

  <xsl:variable name="table" select="document('')/xsl:stylesheet/t:attribute"/>
  <xsl:variable name="units" select="document('')/xsl:stylesheet/t:unit"/>
  <xsl:variable name="user-attributes" select="/System/UserAttribute"/>

  <!-- Channels by name, and by subject as 0x and 16 lower-case digits, which is also the default name. -->
  <xsl:key name="channel" match="EventChannel[@name]" use="normalize-space(@name)"/>
  <xsl:key name="channel" match="EventChannel"
           use="concat('0x', substring('0000000000000000', string-length(normalize-space(SubjectUID)) - 1),
                translate(substring(normalize-space(SubjectUID), 3), 'ABCDEF', 'abcdef'))"/>
  <xsl:key name="use-of" match="Publisher | Subscriber | Binding"
           use="concat(local-name(), ' ', normalize-space(@channel))"/>
  <xsl:key name="use-of" match="Publisher[starts-with(normalize-space(@channel), '0x')] |
                                Subscriber[starts-with(normalize-space(@channel), '0x')] |
                                Binding[starts-with(normalize-space(@channel), '0x')]"
           use="concat(local-name(), ' 0x', substring('0000000000000000', string-length(normalize-space(@channel)) - 1),
                translate(substring(normalize-space(@channel), 3), 'ABCDEF', 'abcdef'))"/>
  <xsl:key name="place" match="Network | Gateway" use="normalize-space(@name)"/>
  <xsl:key name="placement" match="Placement" use="normalize-space(@component)"/>
  <xsl:key name="route" match="Route" use="concat(normalize-space(@from), ' ', normalize-space(@to))"/>
  <xsl:key name="route" match="Route" use="concat(normalize-space(@to), ' ', normalize-space(@from))"/>

  <xsl:include href="check-values.xsl"/>
  <xsl:include href="check-report.xsl"/>
  <xsl:include href="check-sense.xsl"/>

  <!-- ============================ the description as a whole ============================ -->

  <xsl:template match="/">
    <xsl:variable name="found">
      <xsl:if test="not(System)">
        <xsl:call-template name="finding">
          <xsl:with-param name="id" select="'MLCCA003'"/>
          <xsl:with-param name="text" select="'the root element must be System'"/>
        </xsl:call-template>
      </xsl:if>
      <xsl:for-each select="//xi:include">
        <xsl:call-template name="finding">
          <xsl:with-param name="id" select="'MLCCA001'"/>
          <xsl:with-param name="text" select="concat(@href, ' was not included: xsltproc needs -xinclude')"/>
        </xsl:call-template>
      </xsl:for-each>
      <!-- They are handled one by one, because libxslt needs quadratic time for a union of many nodes. -->
      <xsl:apply-templates select="//Attribute" mode="names"/>
      <xsl:apply-templates select="//Publisher" mode="names"/>
      <xsl:apply-templates select="//Subscriber" mode="names"/>
      <xsl:apply-templates select="System/Route/@from | System/Route/@to | System/Route/Hop/@place" mode="names"/>
      <xsl:apply-templates select="//EventChannel"/>
    </xsl:variable>
    <xsl:variable name="left">
      <xsl:apply-templates select="//EventChannel" mode="left"/>
      <xsl:apply-templates select="System/Network" mode="sum"/>
      <xsl:apply-templates select="System/Gateway" mode="sum"/>
      <xsl:if test="System"><xsl:call-template name="rest-left"/></xsl:if>
      <xsl:apply-templates select="//EventChannel" mode="sense"/>
      <xsl:apply-templates select="System/Gateway/Port" mode="sense"/>
    </xsl:variable>
    <xsl:choose>
      <xsl:when test="$format = 'xml'">
        <Findings><xsl:text>&#10;</xsl:text><xsl:copy-of select="$found"/><xsl:copy-of select="$left"/></Findings>
      </xsl:when>
      <xsl:otherwise>
        <xsl:variable name="count" select="string-length($found) - string-length(translate($found, '&#10;', ''))"/>
        <xsl:value-of select="concat($found, $left, $count, ' findings')"/>
      </xsl:otherwise>
    </xsl:choose>
  </xsl:template>

  <xsl:template match="Attribute" mode="names">
    <xsl:variable name="name" select="normalize-space(Name)"/>
    <xsl:if test="not($table[@name = $name]) and not($user-attributes[normalize-space(@name) = $name])">
      <xsl:call-template name="unknown">
        <xsl:with-param name="what" select="concat('attribute ', $name)"/>
      </xsl:call-template>
    </xsl:if>
  </xsl:template>

  <xsl:template match="Publisher | Subscriber" mode="names">
    <xsl:variable name="channel" select="normalize-space(@channel)"/>
    <xsl:variable name="subject"><xsl:apply-templates select="@channel[starts-with($channel, '0x')]" mode="subject"/></xsl:variable>
    <xsl:variable name="place"><xsl:apply-templates select="." mode="place"/></xsl:variable>
    <xsl:if test="not(key('channel', $channel) | key('channel', $subject))">
      <xsl:call-template name="unknown">
        <xsl:with-param name="what" select="concat('channel ', $channel)"/>
      </xsl:call-template>
    </xsl:if>
    <xsl:if test="not(key('place', $place))">
      <xsl:call-template name="unknown">
        <xsl:with-param name="what" select="concat('place ', $place, ' of channel ', $channel)"/>
      </xsl:call-template>
    </xsl:if>
  </xsl:template>

  <xsl:template match="@*" mode="names">
    <xsl:if test="not(key('place', normalize-space(.)))">
      <xsl:call-template name="unknown"><xsl:with-param name="what" select="concat('place ', .)"/></xsl:call-template>
    </xsl:if>
  </xsl:template>

  <xsl:template name="unknown">
    <xsl:param name="what"/>
    <xsl:call-template name="finding">
      <xsl:with-param name="id" select="'MLCCA005'"/>
      <xsl:with-param name="text" select="concat($what, ' is not known')"/>
    </xsl:call-template>
  </xsl:template>

  <!-- ============================ a channel ============================ -->

  <xsl:template match="EventChannel">
    <xsl:variable name="subject"><xsl:apply-templates select="SubjectUID" mode="subject"/></xsl:variable>
    <xsl:variable name="name" select="normalize-space(@name)"/>
    <xsl:variable name="publishers" select="key('use-of', concat('Publisher ', $name)) |
                                            key('use-of', concat('Publisher ', $subject))"/>
    <xsl:variable name="subscribers" select="key('use-of', concat('Subscriber ', $name)) |
                                             key('use-of', concat('Subscriber ', $subject))"/>
    <xsl:choose>
      <xsl:when test="$publishers and $subscribers">
        <xsl:call-template name="check-in-best-set">
          <xsl:with-param name="publishers" select="$publishers"/>
          <xsl:with-param name="subscribers" select="$subscribers"/>
          <xsl:with-param name="bindings" select="key('use-of', concat('Binding ', $name)) |
                                                  key('use-of', concat('Binding ', $subject))"/>
        </xsl:call-template>
      </xsl:when>
      <xsl:otherwise>
        <xsl:variable name="channel" select="."/>
        <xsl:for-each select="$subscribers">
          <xsl:call-template name="finding">
            <xsl:with-param name="id" select="'MLCCA010'"/>
            <xsl:with-param name="channel" select="$channel"/>
            <xsl:with-param name="subscriber" select="."/>
            <xsl:with-param name="text" select="'nobody publishes its channel'"/>
          </xsl:call-template>
        </xsl:for-each>
      </xsl:otherwise>
    </xsl:choose>
  </xsl:template>

  <!-- Notes on what is not checked here, so that no one takes it for fit. -->
  <xsl:template match="EventChannel" mode="left">
    <xsl:variable name="subject"><xsl:apply-templates select="SubjectUID" mode="subject"/></xsl:variable>
    <xsl:variable name="name" select="normalize-space(@name)"/>
    <xsl:variable name="subscribers" select="key('use-of', concat('Subscriber ', $name)) |
                                             key('use-of', concat('Subscriber ', $subject))"/>
    <xsl:for-each select="key('use-of', concat('Publisher ', $name)) | key('use-of', concat('Publisher ', $subject))">
      <xsl:variable name="publisher" select="."/>
      <xsl:variable name="from"><xsl:apply-templates select="." mode="place"/></xsl:variable>
      <xsl:for-each select="$subscribers">
        <xsl:variable name="to"><xsl:apply-templates select="." mode="place"/></xsl:variable>
        <xsl:if test="$from != $to and not(key('route', concat($from, ' ', $to)))">
          <xsl:call-template name="left">
            <xsl:with-param name="publisher" select="$publisher"/>
            <xsl:with-param name="subscriber" select="."/>
            <xsl:with-param name="text" select="concat('no Route is declared between ', $from, ' and ', $to, ': left to mlccactl check')"/>
          </xsl:call-template>
        </xsl:if>
        <!-- A gateway at an end of the route is no hop. -->
        <xsl:variable name="route" select="key('route', concat($from, ' ', $to))"/>
        <xsl:if test="$from != $to and $route and
                      count($route/Hop | key('place', $from)/self::Network | key('place', $to)/self::Network) &gt; 1">
          <xsl:call-template name="left">
            <xsl:with-param name="publisher" select="$publisher"/>
            <xsl:with-param name="subscriber" select="."/>
            <xsl:with-param name="text" select="concat('what the hops from ', $from, ' to ', $to, ' give together is not decided here, left to mlccactl check')"/>
          </xsl:call-template>
        </xsl:if>
      </xsl:for-each>
    </xsl:for-each>
    <xsl:call-template name="check-in-best-set">
      <xsl:with-param name="open" select="true()"/>
      <xsl:with-param name="publishers" select="key('use-of', concat('Publisher ', $name)) | key('use-of', concat('Publisher ', $subject))"/>
      <xsl:with-param name="subscribers" select="$subscribers"/>
      <xsl:with-param name="bindings" select="key('use-of', concat('Binding ', $name)) |
                                              key('use-of', concat('Binding ', $subject))"/>
    </xsl:call-template>
  </xsl:template>

  <!-- The findings of the preferred set; nothing if another set has none. With "open": what is not
       decided here in the first set without a finding. -->
  <xsl:template name="check-in-best-set">
    <xsl:param name="open"/>
    <xsl:param name="publishers"/>
    <xsl:param name="subscribers"/>
    <xsl:param name="bindings"/>
    <xsl:param name="rank" select="1"/>
    <xsl:variable name="id">
      <xsl:for-each select="Attributes">
        <xsl:sort select="translate(@priority, '+', '')" data-type="number" order="descending"/>
        <xsl:if test="position() = $rank"><xsl:value-of select="generate-id()"/></xsl:if>
      </xsl:for-each>
    </xsl:variable>
    <xsl:variable name="channel" select="."/>
    <xsl:variable name="found">
      <xsl:for-each select="$publishers">
        <xsl:variable name="publisher" select="."/>
        <xsl:for-each select="$subscribers">
          <xsl:call-template name="check-pair">
            <xsl:with-param name="channel" select="$channel"/>
            <xsl:with-param name="set" select="$channel/Attributes[generate-id() = $id]"/>
            <xsl:with-param name="publisher" select="$publisher"/>
            <xsl:with-param name="subscriber" select="."/>
            <xsl:with-param name="bindings" select="$bindings"/>
          </xsl:call-template>
        </xsl:for-each>
      </xsl:for-each>
    </xsl:variable>
    <xsl:if test="$open and not(string($found))">
      <xsl:for-each select="$publishers">
        <xsl:variable name="publisher" select="."/>
        <xsl:for-each select="$subscribers">
          <xsl:call-template name="check-pair">
            <xsl:with-param name="open" select="true()"/>
            <xsl:with-param name="channel" select="$channel"/>
            <xsl:with-param name="set" select="$channel/Attributes[generate-id() = $id]"/>
            <xsl:with-param name="publisher" select="$publisher"/>
            <xsl:with-param name="subscriber" select="."/>
            <xsl:with-param name="bindings" select="$bindings"/>
          </xsl:call-template>
        </xsl:for-each>
      </xsl:for-each>
    </xsl:if>
    <xsl:variable name="is-last" select="$rank &gt;= count(Attributes)"/>
    <xsl:if test="$open and string($found) and not($is-last)">
      <xsl:call-template name="check-in-best-set">
        <xsl:with-param name="open" select="true()"/>
        <xsl:with-param name="publishers" select="$publishers"/>
        <xsl:with-param name="subscribers" select="$subscribers"/>
        <xsl:with-param name="bindings" select="$bindings"/>
        <xsl:with-param name="rank" select="$rank + 1"/>
      </xsl:call-template>
    </xsl:if>
    <xsl:variable name="lower">
      <xsl:if test="not($open) and string($found) and not($is-last)">
        <xsl:call-template name="check-in-best-set">
          <xsl:with-param name="publishers" select="$publishers"/>
          <xsl:with-param name="subscribers" select="$subscribers"/>
          <xsl:with-param name="bindings" select="$bindings"/>
          <xsl:with-param name="rank" select="$rank + 1"/>
        </xsl:call-template>
      </xsl:if>
    </xsl:variable>
    <!-- Every set has findings. mlccactl check uses the first one unless a lower one serves more ends. -->
    <xsl:variable name="served">
      <xsl:if test="string($found) and (($open and $is-last and $rank &gt; 1) or ($rank = 1 and string($lower)))">
        <xsl:call-template name="served-in-lower-set">
          <xsl:with-param name="publishers" select="$publishers"/>
          <xsl:with-param name="subscribers" select="$subscribers"/>
          <xsl:with-param name="bindings" select="$bindings"/>
        </xsl:call-template>
      </xsl:if>
    </xsl:variable>
    <xsl:choose>
      <xsl:when test="$open"><xsl:copy-of select="$served"/></xsl:when>
      <xsl:when test="not(string($served)) and ($is-last or string($lower))"><xsl:copy-of select="$found"/></xsl:when>
    </xsl:choose>
  </xsl:template>

  <!-- A note for each publisher and subscriber without findings in a set other than the preferred one:
       either all subscribers at one place are served, or none. -->
  <xsl:template name="served-in-lower-set">
    <xsl:param name="publishers"/>
    <xsl:param name="subscribers"/>
    <xsl:param name="bindings"/>
    <xsl:param name="rank" select="2"/>
    <xsl:param name="said" select="'|'"/>
    <xsl:variable name="id">
      <xsl:for-each select="Attributes">
        <xsl:sort select="translate(@priority, '+', '')" data-type="number" order="descending"/>
        <xsl:if test="position() = $rank"><xsl:value-of select="generate-id()"/></xsl:if>
      </xsl:for-each>
    </xsl:variable>
    <xsl:variable name="channel" select="."/>
    <xsl:variable name="failing">
      <xsl:text>|</xsl:text>
      <xsl:for-each select="$publishers">
        <xsl:variable name="publisher" select="."/>
        <xsl:for-each select="$subscribers">
          <xsl:variable name="found">
            <xsl:call-template name="check-pair">
              <xsl:with-param name="channel" select="$channel"/>
              <xsl:with-param name="set" select="$channel/Attributes[generate-id() = $id]"/>
              <xsl:with-param name="publisher" select="$publisher"/>
              <xsl:with-param name="subscriber" select="."/>
              <xsl:with-param name="bindings" select="$bindings"/>
            </xsl:call-template>
          </xsl:variable>
          <xsl:if test="string($found)">
            <xsl:value-of select="concat(generate-id($publisher), ' ')"/>
            <xsl:apply-templates select="." mode="place"/>
            <xsl:text>|</xsl:text>
          </xsl:if>
        </xsl:for-each>
      </xsl:for-each>
    </xsl:variable>
    <xsl:variable name="now">
      <xsl:for-each select="$publishers">
        <xsl:variable name="publisher" select="."/>
        <xsl:for-each select="$subscribers">
          <xsl:variable name="place"><xsl:apply-templates select="." mode="place"/></xsl:variable>
          <xsl:if test="not(contains($failing, concat('|', generate-id($publisher), ' ', $place, '|')))">
            <xsl:value-of select="concat(generate-id($publisher), ' ', generate-id(), '|')"/>
          </xsl:if>
        </xsl:for-each>
      </xsl:for-each>
    </xsl:variable>
    <xsl:for-each select="$publishers">
      <xsl:variable name="publisher" select="."/>
      <xsl:for-each select="$subscribers">
        <xsl:variable name="key" select="concat('|', generate-id($publisher), ' ', generate-id(), '|')"/>
        <xsl:if test="contains(concat('|', $now), $key) and not(contains($said, $key))">
          <xsl:call-template name="left">
            <xsl:with-param name="publisher" select="$publisher"/>
            <xsl:with-param name="subscriber" select="."/>
            <xsl:with-param name="text" select="'no attribute set is right for all, and a lower one may be used for this: not decided here, left to mlccactl check'"/>
          </xsl:call-template>
        </xsl:if>
      </xsl:for-each>
    </xsl:for-each>
    <xsl:if test="$rank &lt; count(Attributes)">
      <xsl:call-template name="served-in-lower-set">
        <xsl:with-param name="publishers" select="$publishers"/>
        <xsl:with-param name="subscribers" select="$subscribers"/>
        <xsl:with-param name="bindings" select="$bindings"/>
        <xsl:with-param name="rank" select="$rank + 1"/>
        <xsl:with-param name="said" select="concat($said, $now)"/>
      </xsl:call-template>
    </xsl:if>
  </xsl:template>

  <!-- A Bandwidth is compared with each channel alone. -->
  <xsl:template match="Network | Gateway" mode="sum">
    <xsl:if test="Provision[@bandwidth or Attribute[normalize-space(Name) = 'Bandwidth']]">
      <xsl:call-template name="sum-left"/>
    </xsl:if>
  </xsl:template>

  <!-- ============================ a publisher and a subscriber ============================ -->

  <xsl:template name="check-pair">
    <xsl:param name="open"/>
    <xsl:param name="channel"/>
    <xsl:param name="set"/>
    <xsl:param name="publisher"/>
    <xsl:param name="subscriber"/>
    <xsl:param name="bindings"/>
    <xsl:variable name="from"><xsl:apply-templates select="$publisher" mode="place"/></xsl:variable>
    <xsl:variable name="to"><xsl:apply-templates select="$subscriber" mode="place"/></xsl:variable>
    <xsl:variable name="route" select="key('route', concat($from, ' ', $to))"/>
    <!-- A gateway at an end of the route is no hop: the program runs there. -->
    <xsl:variable name="legs" select="key('place', $from)[$from = $to]/self::Network/@name |
                                      $route/@from | $route/@to | $route/Hop/@place"/>
    <xsl:variable name="names">
      <xsl:text> </xsl:text>
      <xsl:for-each select="($set | $publisher/Attributes | $subscriber/Attributes)/Attribute/Name">
        <xsl:value-of select="concat(normalize-space(), ' ')"/>
        <xsl:if test="normalize-space() = 'Period'">Deadline Bandwidth </xsl:if>
      </xsl:for-each>
      <xsl:for-each select="($set | $publisher/Attributes | $subscriber/Attributes)/@*[name() != 'priority']">
        <xsl:value-of select="concat(translate(substring(name(), 1, 1), 'abcdefghijklmnopqrstuvwxyz', 'ABCDEFGHIJKLMNOPQRSTUVWXYZ'), substring(name(), 2), ' ')"/>
        <xsl:if test="name() = 'period'">Deadline Bandwidth </xsl:if>
      </xsl:for-each>
    </xsl:variable>
    <!-- The rows of the table are in another document, in which a key finds nothing of this one. -->
    <xsl:for-each select="($table | $user-attributes)[contains($names, concat(' ', normalize-space(@name), ' '))]">
      <xsl:call-template name="check-attribute">
        <xsl:with-param name="open" select="$open"/>
        <xsl:with-param name="channel" select="$channel"/>
        <xsl:with-param name="set" select="$set"/>
        <xsl:with-param name="publisher" select="$publisher"/>
        <xsl:with-param name="subscriber" select="$subscriber"/>
        <xsl:with-param name="bindings" select="$bindings"/>
        <xsl:with-param name="legs" select="$legs"/>
      </xsl:call-template>
    </xsl:for-each>
  </xsl:template>

  <!-- The current node is the attribute's row. -->
  <xsl:template name="check-attribute">
    <xsl:param name="open"/>
    <xsl:param name="channel"/>
    <xsl:param name="set"/>
    <xsl:param name="publisher"/>
    <xsl:param name="subscriber"/>
    <xsl:param name="bindings"/>
    <xsl:param name="legs"/>
    <xsl:variable name="row" select="."/>
    <xsl:variable name="offered">
      <xsl:call-template name="required-by">
        <xsl:with-param name="end" select="$publisher"/>
        <xsl:with-param name="set" select="$set"/>
      </xsl:call-template>
    </xsl:variable>
    <xsl:variable name="asked">
      <xsl:call-template name="required-by">
        <xsl:with-param name="end" select="$subscriber"/>
        <xsl:with-param name="set" select="$set"/>
      </xsl:call-template>
    </xsl:variable>
    <xsl:if test="@traffic and string($asked) and not($open)">
      <xsl:call-template name="check-traffic">
        <xsl:with-param name="channel" select="$channel"/>
        <xsl:with-param name="set" select="$set"/>
        <xsl:with-param name="publisher" select="$publisher"/>
        <xsl:with-param name="subscriber" select="$subscriber"/>
        <xsl:with-param name="offered" select="string($offered)"/>
        <xsl:with-param name="asked" select="string($asked)"/>
      </xsl:call-template>
    </xsl:if>
    <!-- The publisher's Jitter is the source jitter; the size to be carried is the publisher's. -->
    <xsl:variable name="union">
      <xsl:choose>
        <xsl:when test="@name = 'Jitter'"><xsl:value-of select="$asked"/></xsl:when>
        <xsl:when test="not(string($asked)) or (@name = 'MaxPayload' and string($offered))"><xsl:value-of select="$offered"/></xsl:when>
        <xsl:when test="not(string($offered))"><xsl:value-of select="$asked"/></xsl:when>
        <xsl:otherwise>
          <xsl:variable name="offered-fails">
            <xsl:call-template name="fails">
              <xsl:with-param name="value" select="$offered"/>
              <xsl:with-param name="bound" select="$asked"/>
            </xsl:call-template>
          </xsl:variable>
          <xsl:choose>
            <xsl:when test="string($offered-fails)"><xsl:value-of select="$asked"/></xsl:when>
            <xsl:otherwise><xsl:value-of select="$offered"/></xsl:otherwise>
          </xsl:choose>
        </xsl:otherwise>
      </xsl:choose>
    </xsl:variable>
    <xsl:if test="$open and @name = 'Bandwidth' and not(string($union))">
      <xsl:call-template name="leave-medium-time">
        <xsl:with-param name="set" select="$set"/>
        <xsl:with-param name="publisher" select="$publisher"/>
        <xsl:with-param name="subscriber" select="$subscriber"/>
        <xsl:with-param name="legs" select="$legs"/>
      </xsl:call-template>
    </xsl:if>
    <xsl:if test="string($union)">
      <xsl:for-each select="$legs">
        <xsl:variable name="hop" select="key('place', normalize-space(.))"/>
        <xsl:if test="$hop/self::Network or parent::Hop">
          <xsl:call-template name="check-hop">
            <xsl:with-param name="open" select="$open"/>
            <xsl:with-param name="row" select="$row"/>
            <xsl:with-param name="channel" select="$channel"/>
            <xsl:with-param name="set" select="$set"/>
            <xsl:with-param name="publisher" select="$publisher"/>
            <xsl:with-param name="subscriber" select="$subscriber"/>
            <xsl:with-param name="hop" select="$hop"/>
            <xsl:with-param name="binding" select="$bindings[generate-id(..) = generate-id($hop)]"/>
            <xsl:with-param name="required" select="string($union)"/>
          </xsl:call-template>
        </xsl:if>
      </xsl:for-each>
    </xsl:if>
  </xsl:template>

  <!-- A note: the medium time that events take on a mesh is computed, whether they state a Bandwidth or
       not. The current node is the row of Bandwidth. -->
  <xsl:template name="leave-medium-time">
    <xsl:param name="set"/>
    <xsl:param name="publisher"/>
    <xsl:param name="subscriber"/>
    <xsl:param name="legs"/>
    <xsl:variable name="row" select="."/>
    <xsl:variable name="rate">
      <xsl:call-template name="rate-of">
        <xsl:with-param name="set" select="$set"/>
        <xsl:with-param name="publisher" select="$publisher"/>
      </xsl:call-template>
    </xsl:variable>
    <xsl:for-each select="$legs[string($rate)]">
      <xsl:variable name="hop" select="key('place', normalize-space(.))/self::Network[Mesh]"/>
      <xsl:if test="$hop">
        <xsl:call-template name="undecided">
          <xsl:with-param name="publisher" select="$publisher"/>
          <xsl:with-param name="subscriber" select="$subscriber"/>
          <xsl:with-param name="hop" select="$hop"/>
          <xsl:with-param name="row" select="$row"/>
          <xsl:with-param name="required" select="string($rate)"/>
        </xsl:call-template>
      </xsl:if>
    </xsl:for-each>
  </xsl:template>

  <!-- The rate that follows from the size and the Period of the events; empty if one is not stated. -->
  <xsl:template name="rate-of">
    <xsl:param name="set"/>
    <xsl:param name="publisher"/>
    <xsl:call-template name="rate">
      <xsl:with-param name="bytes">
        <xsl:call-template name="required-by">
          <xsl:with-param name="end" select="$publisher"/>
          <xsl:with-param name="set" select="$set"/>
          <xsl:with-param name="row" select="$table[@name = 'MaxPayload']"/>
        </xsl:call-template>
      </xsl:with-param>
      <xsl:with-param name="period">
        <xsl:call-template name="required-by">
          <xsl:with-param name="end" select="$publisher"/>
          <xsl:with-param name="set" select="$set"/>
          <xsl:with-param name="row" select="$table[@name = 'Period']"/>
        </xsl:call-template>
      </xsl:with-param>
    </xsl:call-template>
  </xsl:template>

  <!-- Compares the traffic that the publisher really offers. The current node is the attribute's row. -->
  <xsl:template name="check-traffic">
    <xsl:param name="channel"/>
    <xsl:param name="set"/>
    <xsl:param name="publisher"/>
    <xsl:param name="subscriber"/>
    <xsl:param name="offered"/>
    <xsl:param name="asked"/>
    <xsl:variable name="provided">
      <xsl:choose>
        <xsl:when test="@name = 'Bandwidth' and $offered = ''">
          <xsl:call-template name="rate-of">
            <xsl:with-param name="set" select="$set"/>
            <xsl:with-param name="publisher" select="$publisher"/>
          </xsl:call-template>
        </xsl:when>
        <xsl:otherwise><xsl:value-of select="$offered"/></xsl:otherwise>
      </xsl:choose>
    </xsl:variable>
    <xsl:call-template name="compare">
      <xsl:with-param name="id" select="'MLCCA020'"/>
      <xsl:with-param name="row" select="."/>
      <xsl:with-param name="channel" select="$channel"/>
      <xsl:with-param name="publisher" select="$publisher"/>
      <xsl:with-param name="subscriber" select="$subscriber"/>
      <xsl:with-param name="required" select="$asked"/>
      <xsl:with-param name="provided" select="string($provided)"/>
      <xsl:with-param name="better" select="@traffic"/>
    </xsl:call-template>
  </xsl:template>

  <xsl:template name="check-hop">
    <xsl:param name="open"/>
    <xsl:param name="row"/>
    <xsl:param name="channel"/>
    <xsl:param name="set"/>
    <xsl:param name="publisher"/>
    <xsl:param name="subscriber"/>
    <xsl:param name="hop"/>
    <xsl:param name="binding"/>
    <xsl:param name="required"/>
    <xsl:variable name="stated">
      <xsl:call-template name="provided-by">
        <xsl:with-param name="hop" select="$hop"/>
        <xsl:with-param name="row" select="$row"/>
      </xsl:call-template>
    </xsl:variable>
    <xsl:variable name="computed">
      <xsl:call-template name="is-computed">
        <xsl:with-param name="hop" select="$hop"/>
        <xsl:with-param name="row" select="$row"/>
      </xsl:call-template>
    </xsl:variable>
    <!-- A provision that is stated for a bus with a bit rate can be refuted by the response times there.
         Frames that are or may be FD or XL need the data bit rate. -->
    <xsl:variable name="on-time" select="$row/@name = 'Deadline' or $row/@name = 'Latency'"/>
    <xsl:variable name="timed" select="$hop/self::Network[Profile and (Bus/@bitrate or $binding[normalize-space(@format) != ''
                                                            and normalize-space(@format) != 'classic'])]"/>
    <!-- A provision that is stated for a mesh can be refuted by what its links provide. -->
    <xsl:variable name="by-links" select="key('given-by-links', concat(generate-id($hop), ' ', substring('Latency', 1, 7 * $on-time),
                                                substring($row/@name, 1, string-length($row/@name) * not($on-time)))) |
                                          key('given-by-links', concat(generate-id($hop[$on-time]), ' Period'))"/>
    <!-- One that is stated for a J1939 bus can be refuted by the pauses between the frames of a message. -->
    <xsl:variable name="paused">
      <xsl:if test="($on-time or $row/@name = 'Jitter') and normalize-space($hop/Profile[1]) = 'j1939'">
        <xsl:call-template name="is-fragmented">
          <xsl:with-param name="set" select="$set"/>
          <xsl:with-param name="publisher" select="$publisher"/>
          <xsl:with-param name="hop" select="$hop"/>
          <xsl:with-param name="binding" select="$binding"/>
        </xsl:call-template>
      </xsl:if>
    </xsl:variable>
    <xsl:if test="$open and (string($computed) or ($on-time and $timed) or $by-links or string($paused))">
      <xsl:call-template name="undecided">
        <xsl:with-param name="publisher" select="$publisher"/>
        <xsl:with-param name="subscriber" select="$subscriber"/>
        <xsl:with-param name="hop" select="$hop"/>
        <xsl:with-param name="row" select="$row"/>
        <xsl:with-param name="required" select="$required"/>
      </xsl:call-template>
    </xsl:if>
    <xsl:variable name="composition" select="normalize-space($row/Composition)"/>
    <xsl:variable name="limits-by-statement-only" select="$row/@of-networks or $composition = 'maximum' or $composition = 'minimum'"/>
    <xsl:if test="not($open) and not(string($computed)) and not(string($paused)) and
                  (string($stated) or $hop/self::Network or not($limits-by-statement-only))">
      <xsl:variable name="unbounded-by-fragments">
        <xsl:if test="$row/@name = 'Omission' and string($stated) and $stated != $none">
          <xsl:call-template name="is-fragmented">
            <xsl:with-param name="set" select="$set"/>
            <xsl:with-param name="publisher" select="$publisher"/>
            <xsl:with-param name="hop" select="$hop"/>
            <xsl:with-param name="binding" select="$binding"/>
          </xsl:call-template>
        </xsl:if>
      </xsl:variable>
      <xsl:call-template name="compare">
        <xsl:with-param name="id" select="'MLCCA021'"/>
        <xsl:with-param name="row" select="$row"/>
        <xsl:with-param name="channel" select="$channel"/>
        <xsl:with-param name="publisher" select="$publisher"/>
        <xsl:with-param name="subscriber" select="$subscriber"/>
        <xsl:with-param name="hop" select="$hop"/>
        <xsl:with-param name="required" select="$required"/>
        <xsl:with-param name="provided">
          <xsl:choose>
            <xsl:when test="string($unbounded-by-fragments)"><xsl:value-of select="$unbounded"/></xsl:when>
            <xsl:otherwise><xsl:value-of select="$stated"/></xsl:otherwise>
          </xsl:choose>
        </xsl:with-param>
      </xsl:call-template>
    </xsl:if>
  </xsl:template>

  <!-- Not empty if an event of the publisher needs several frames: it is longer than a frame of FAMOUSO or
       Cyphal (which needs one byte of it), or than a classic frame of a J1939 broadcast. -->
  <xsl:template name="is-fragmented">
    <xsl:param name="set"/>
    <xsl:param name="publisher"/>
    <xsl:param name="hop"/>
    <xsl:param name="binding"/>
    <xsl:variable name="profile" select="normalize-space($hop/Profile[1])"/>
    <xsl:variable name="to" select="normalize-space($binding/PGN/@destination)"/>
    <xsl:variable name="broadcast" select="$to = '' or $to = '255' or $to = '0xff' or $to = '0xFF'"/>
    <xsl:if test="$binding and ($profile = 'famouso' or $profile = 'cyphal' or
                  ($profile = 'j1939' and $broadcast and not($binding/@format != 'classic')))">
      <xsl:variable name="bytes">
        <xsl:call-template name="required-by">
          <xsl:with-param name="end" select="$publisher"/>
          <xsl:with-param name="set" select="$set"/>
          <xsl:with-param name="row" select="$table[@name = 'MaxPayload']"/>
        </xsl:call-template>
      </xsl:variable>
      <xsl:variable name="format" select="normalize-space($binding/@format)"/>
      <xsl:variable name="room"
          select="8 + 56 * ($format = 'fd' or $format = 'any') - ($profile = 'cyphal')"/>
      <xsl:if test="$bytes &gt; $room">yes</xsl:if>
    </xsl:if>
  </xsl:template>

  <!-- A finding, unless the provided value fulfils the required one. -->
  <xsl:template name="compare">
    <xsl:param name="id"/>
    <xsl:param name="row"/>
    <xsl:param name="channel"/>
    <xsl:param name="publisher"/>
    <xsl:param name="subscriber"/>
    <xsl:param name="hop" select="/.."/>
    <xsl:param name="required"/>
    <xsl:param name="provided"/>
    <xsl:param name="better" select="concat($row/@better, normalize-space($row/Better))"/>
    <xsl:variable name="fails">
      <xsl:if test="string($provided)">
        <xsl:call-template name="fails">
          <xsl:with-param name="value" select="$provided"/>
          <xsl:with-param name="bound" select="$required"/>
          <xsl:with-param name="better" select="$better"/>
        </xsl:call-template>
      </xsl:if>
    </xsl:variable>
    <xsl:if test="not(string($provided)) or string($fails)">
      <xsl:call-template name="finding">
        <xsl:with-param name="id" select="$id"/>
        <xsl:with-param name="channel" select="$channel"/>
        <xsl:with-param name="publisher" select="$publisher"/>
        <xsl:with-param name="subscriber" select="$subscriber"/>
        <xsl:with-param name="hop" select="$hop"/>
        <xsl:with-param name="row" select="$row"/>
        <xsl:with-param name="required" select="string($required)"/>
        <xsl:with-param name="provided" select="string($provided)"/>
      </xsl:call-template>
    </xsl:if>
  </xsl:template>
</xsl:stylesheet>
