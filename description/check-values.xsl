<?xml version="1.0" encoding="UTF-8"?>
<!-- SPDX-License-Identifier: BSD-2-Clause -->
<!--
  For check.xsl: the values that ends, networks and gateways state, as integers of 20 digits in strings,
  because XSLT has only floating point, which is exact up to 15 digits.
-->
<xsl:stylesheet version="1.0" xmlns:xsl="http://www.w3.org/1999/XSL/Transform"
                xmlns:t="urn:mlcca:table" exclude-result-prefixes="t">
  <!-- As many zeros as the largest Magnitudes append to a value. -->
  <xsl:variable name="zeros" select="'00000000000000000000000000000000000000000000000000000000000000000000000000000000'"/>
  <xsl:variable name="none" select="substring($zeros, 1, 20)"/>
  <xsl:variable name="unbounded" select="'18446744073709551615'"/>

  <!-- Provided values by the name of the attribute in the table: an XML attribute "period" is "Period". -->
  <xsl:key name="provided" match="Provision/Attribute" use="concat(generate-id(../..), ' ', normalize-space(Name))"/>
  <xsl:key name="provided" match="Provision/@*[name() != 'dynamic']"
           use="concat(generate-id(../..), ' ', translate(substring(name(), 1, 1), 'abcdefghijklmnopqrstuvwxyz', 'ABCDEFGHIJKLMNOPQRSTUVWXYZ'),
                       substring(name(), 2))"/>

  <!-- The same for the values that each link of a mesh provides. -->
  <xsl:key name="given-by-links" match="PerHop/Attribute" use="concat(generate-id(../../..), ' ', normalize-space(Name))"/>
  <xsl:key name="given-by-links" match="PerHop/@*[name() != 'dynamic']"
           use="concat(generate-id(../../..), ' ', translate(substring(name(), 1, 1), 'abcdefghijklmnopqrstuvwxyz', 'ABCDEFGHIJKLMNOPQRSTUVWXYZ'),
                       substring(name(), 2))"/>

  <!-- ============================ what is stated ============================ -->

  <!--
    The value that an end requires (or offers) in a channel's set, or empty: its own for that set, else
    its own for every set, else the channel's. A publisher does not inherit the channel's Jitter, which is
    what subscribers accept. A Period without a Deadline requires Deadline = Period.
  -->
  <xsl:template name="required-by">
    <xsl:param name="end"/>
    <xsl:param name="set"/>
    <xsl:param name="row" select="."/>
    <xsl:param name="name" select="normalize-space($row/@name)"/>
    <xsl:variable name="short" select="concat(translate(substring($name, 1, 1), 'ABCDEFGHIJKLMNOPQRSTUVWXYZ', 'abcdefghijklmnopqrstuvwxyz'), substring($name, 2))"/>
    <xsl:variable name="priority" select="number(translate($set/@priority, '+', ''))"/>
    <xsl:variable name="sets" select="$end/Attributes[number(translate(@priority, '+', '')) = $priority]"/>
    <xsl:variable name="of-set" select="$sets/Attribute[normalize-space(Name) = $name] | $sets/@*[name() = $short and $row/self::t:attribute]"/>
    <xsl:variable name="always" select="$end/Attributes[not(@priority)]"/>
    <xsl:variable name="of-all" select="$always/Attribute[normalize-space(Name) = $name] | $always/@*[name() = $short and $row/self::t:attribute]"/>
    <xsl:variable name="common" select="$set[$end/self::Subscriber or $name != 'Jitter']"/>
    <xsl:variable name="inherited" select="$common/Attribute[normalize-space(Name) = $name] | $common/@*[name() = $short and $row/self::t:attribute]"/>
    <xsl:variable name="attribute" select="$of-set | $of-all[not($of-set)] | $inherited[not($of-set or $of-all)]"/>
    <xsl:choose>
      <xsl:when test="$attribute">
        <xsl:call-template name="whole">
          <xsl:with-param name="attribute" select="$attribute"/>
          <xsl:with-param name="row" select="$row"/>
          <xsl:with-param name="up" select="concat($row/@better, normalize-space($row/Better)) = 'larger'"/>
        </xsl:call-template>
      </xsl:when>
      <xsl:when test="$name = 'Deadline'">
        <xsl:call-template name="required-by">
          <xsl:with-param name="end" select="$end"/>
          <xsl:with-param name="set" select="$set"/>
          <xsl:with-param name="row" select="$row"/>
          <xsl:with-param name="name" select="'Period'"/>
        </xsl:call-template>
      </xsl:when>
    </xsl:choose>
  </xsl:template>

  <!--
    The value that a network or gateway provides, or empty. A Deadline is compared with the Latency;
    a Period without a Latency promises Latency = Period.
  -->
  <xsl:template name="provided-by">
    <xsl:param name="hop"/>
    <xsl:param name="row"/>
    <xsl:variable name="name" select="normalize-space($row/@name)"/>
    <xsl:variable name="held-against">
      <xsl:choose>
        <xsl:when test="$name = 'Deadline'">Latency</xsl:when>
        <xsl:otherwise><xsl:value-of select="$name"/></xsl:otherwise>
      </xsl:choose>
    </xsl:variable>
    <xsl:variable name="stated" select="key('provided', concat(generate-id($hop), ' ', $held-against))"/>
    <xsl:variable name="implied" select="key('provided', concat(generate-id($hop[$held-against = 'Latency']), ' Period'))"/>
    <xsl:variable name="attribute" select="$stated | $implied[not($stated)]"/>
    <xsl:if test="$attribute">
      <xsl:call-template name="whole">
        <xsl:with-param name="attribute" select="$attribute"/>
        <xsl:with-param name="row" select="$row"/>
        <xsl:with-param name="up" select="concat($row/@better, normalize-space($row/Better)) = 'smaller'"/>
      </xsl:call-template>
    </xsl:if>
  </xsl:template>

  <!--
    Not empty if the value that a hop provides is computed: on a CAN bus with a bit rate its times,
    periods and sizes, on a mesh every attribute of the table, unless a value is stated that is no best
    case.
  -->
  <xsl:template name="is-computed">
    <xsl:param name="hop"/>
    <xsl:param name="row"/>
    <xsl:variable name="name" select="normalize-space($row/@name)"/>
    <xsl:variable name="held-against" select="concat(substring('Latency', 1, 7 * ($name = 'Deadline')),
                                                     substring($name, 1, string-length($name) * ($name != 'Deadline')))"/>
    <xsl:variable name="stated" select="key('provided', concat(generate-id($hop), ' ', $held-against))"/>
    <xsl:variable name="for-good" select="$stated[not(normalize-space(@dynamic) = 'true' or normalize-space(@dynamic) = '1')]
        [not(normalize-space(../@dynamic) = 'true' or normalize-space(../@dynamic) = '1')]"/>
    <xsl:variable name="on-a-bus" select="contains(' Latency Jitter Period MaxPayload ', concat(' ', $held-against, ' '))"/>
    <xsl:if test="$row/self::t:attribute and not($for-good) and
                  ($hop/self::Network[Mesh] or ($on-a-bus and $hop/self::Network[Bus/@bitrate and Profile]))">yes</xsl:if>
  </xsl:template>

  <!-- The name of the network or gateway where an end sits. -->
  <xsl:template match="Publisher | Subscriber" mode="place">
    <xsl:variable name="own" select="@network | @gateway"/>
    <xsl:variable name="component" select="parent::Component[not($own)]"/>
    <xsl:variable name="components" select="$component/@network | $component/@gateway"/>
    <xsl:variable name="placement" select="key('placement', normalize-space($component[not($components)]/@name))"/>
    <xsl:value-of select="normalize-space($own | $components | $placement/@network | $placement/@gateway)"/>
  </xsl:template>

  <!-- ============================ numbers ============================ -->

  <!-- A subject as 0x and 16 lower-case digits. -->
  <xsl:template match="SubjectUID | @channel" mode="subject">
    <xsl:variable name="text" select="normalize-space()"/>
    <xsl:value-of select="concat('0x', substring('0000000000000000', string-length($text) - 1),
                                 translate(substring($text, 3), 'ABCDEF', 'abcdef'))"/>
  </xsl:template>

  <!-- The Magnitude of a Dimension; 0 if there is none. -->
  <xsl:template name="magnitude">
    <xsl:param name="of"/>
    <xsl:choose>
      <xsl:when test="$of/Dimension/Magnitude"><xsl:value-of select="translate(normalize-space($of/Dimension/Magnitude), '+', '')"/></xsl:when>
      <xsl:otherwise>0</xsl:otherwise>
    </xsl:choose>
  </xsl:template>

  <!--
    The integer value of an Attribute, or of an XML attribute with its unit, in the unit of its row: the
    point is moved, and the digits after it are cut.
  -->
  <xsl:template name="whole">
    <xsl:param name="attribute"/>
    <xsl:param name="row"/>
    <xsl:param name="up"/>
    <xsl:variable name="stated" select="normalize-space($attribute/Value | $attribute[not(self::*)])"/>
    <xsl:variable name="unit" select="translate($stated, '0123456789.', '')"/>
    <!-- The second term is for "+3", which is no number to XPath; without a sign it is 0. -->
    <xsl:variable name="magnitude" select="sum($units[@name = $unit]/@power) + sum($attribute/Dimension/Magnitude[not(contains(., '+'))]) +
                                           concat('0', normalize-space(substring-after($attribute/Dimension/Magnitude, '+')))"/>
    <xsl:variable name="resolution" select="sum($row/Dimension/Magnitude[not(contains(., '+'))]) +
                                            concat('0', normalize-space(substring-after($row/Dimension/Magnitude, '+')))"/>
    <xsl:variable name="decimal" select="substring($stated, 1, string-length($stated) - string-length($unit))"/>
    <xsl:variable name="before" select="substring-before(concat($decimal, '.'), '.')"/>
    <xsl:variable name="digits" select="concat($before, substring-after($decimal, '.'))"/>
    <xsl:variable name="kept" select="string-length($before) + $magnitude - $resolution + sum($row/@scale)"/>
    <xsl:variable name="head" select="substring(concat($digits, $zeros), 1, $kept)"/>
    <xsl:variable name="value" select="substring(concat($none, $head), string-length($head) + 1)"/>
    <xsl:choose>
      <xsl:when test="$up and translate(substring($digits, 1 + $kept * ($kept &gt; 0)), '0', '') != ''">
        <xsl:call-template name="next"><xsl:with-param name="value" select="$value"/></xsl:call-template>
      </xsl:when>
      <xsl:otherwise><xsl:value-of select="$value"/></xsl:otherwise>
    </xsl:choose>
  </xsl:template>

  <!-- The value plus one. Ten digits are exact in floating point, twenty are not. -->
  <xsl:template name="next">
    <xsl:param name="value"/>
    <xsl:variable name="low" select="substring($value, 11) + 1"/>
    <xsl:variable name="carry" select="$low = 10000000000"/>
    <xsl:value-of select="concat(format-number(substring($value, 1, 10) + $carry, '0000000000'),
                                 format-number($low * not($carry), '0000000000'))"/>
  </xsl:template>

  <!-- Not empty if the value is on the wrong side of the bound. -->
  <xsl:template name="fails">
    <xsl:param name="value"/>
    <xsl:param name="bound"/>
    <xsl:param name="better" select="concat(@better, normalize-space(Better))"/>
    <xsl:variable name="high" select="substring($value, 1, 10) - substring($bound, 1, 10)"/>
    <xsl:variable name="low" select="substring($value, 11) - substring($bound, 11)"/>
    <xsl:variable name="over" select="$high &gt; 0 or ($high = 0 and $low &gt; 0)"/>
    <xsl:if test="$value != $bound and $over = ($better = 'smaller')">yes</xsl:if>
  </xsl:template>

  <!-- bytes in every period (ns) as bytes/s, rounded down; empty if one of them is not stated. -->
  <xsl:template name="rate">
    <xsl:param name="bytes"/>
    <xsl:param name="period"/>
    <xsl:if test="string($bytes) and string($period)">
      <xsl:variable name="quotient">
        <xsl:call-template name="divide">
          <xsl:with-param name="digits" select="concat($bytes, '000000000')"/>
          <xsl:with-param name="divisor-high" select="number(substring($period, 1, 10))"/>
          <xsl:with-param name="divisor-low" select="number(substring($period, 11))"/>
        </xsl:call-template>
      </xsl:variable>
      <xsl:variable name="too-large">
        <xsl:call-template name="fails">
          <xsl:with-param name="value" select="substring($quotient, 11)"/>
          <xsl:with-param name="bound" select="$unbounded"/>
          <xsl:with-param name="better" select="'smaller'"/>
        </xsl:call-template>
      </xsl:variable>
      <xsl:choose>
        <xsl:when test="translate(substring($quotient, 1, 10), '0', '') != '' or string($too-large)"><xsl:value-of select="$unbounded"/></xsl:when>
        <xsl:otherwise><xsl:value-of select="substring($quotient, 11)"/></xsl:otherwise>
      </xsl:choose>
    </xsl:if>
  </xsl:template>

  <!--
    Long division: one digit of the quotient for each of the dividend, after a leading 0. The remainder
    is in two halves of ten digits, like the divisor.
  -->
  <xsl:template name="divide">
    <xsl:param name="digits"/>
    <xsl:param name="divisor-high"/>
    <xsl:param name="divisor-low"/>
    <xsl:param name="high" select="0"/>
    <xsl:param name="low" select="0"/>
    <xsl:param name="digit" select="0"/>
    <xsl:choose>
      <xsl:when test="$high &gt; $divisor-high or ($high = $divisor-high and $low &gt;= $divisor-low)">
        <xsl:variable name="borrow" select="number($low &lt; $divisor-low)"/>
        <xsl:call-template name="divide">
          <xsl:with-param name="digits" select="$digits"/>
          <xsl:with-param name="divisor-high" select="$divisor-high"/>
          <xsl:with-param name="divisor-low" select="$divisor-low"/>
          <xsl:with-param name="high" select="$high - $divisor-high - $borrow"/>
          <xsl:with-param name="low" select="$low - $divisor-low + $borrow * 10000000000"/>
          <xsl:with-param name="digit" select="$digit + 1"/>
        </xsl:call-template>
      </xsl:when>
      <xsl:otherwise>
        <xsl:value-of select="$digit"/>
        <xsl:if test="$digits != ''">
          <xsl:variable name="next" select="$low * 10 + substring($digits, 1, 1)"/>
          <xsl:variable name="carry" select="floor($next div 10000000000)"/>
          <xsl:call-template name="divide">
            <xsl:with-param name="digits" select="substring($digits, 2)"/>
            <xsl:with-param name="divisor-high" select="$divisor-high"/>
            <xsl:with-param name="divisor-low" select="$divisor-low"/>
            <xsl:with-param name="high" select="$high * 10 + $carry"/>
            <xsl:with-param name="low" select="$next - $carry * 10000000000"/>
          </xsl:call-template>
        </xsl:if>
      </xsl:otherwise>
    </xsl:choose>
  </xsl:template>

  <!-- The number without leading zeros. -->
  <xsl:template name="plain">
    <xsl:param name="value"/>
    <xsl:variable name="first" select="substring(translate($value, '0', ''), 1, 1)"/>
    <xsl:choose>
      <xsl:when test="$first = ''">0</xsl:when>
      <xsl:otherwise><xsl:value-of select="concat($first, substring-after($value, $first))"/></xsl:otherwise>
    </xsl:choose>
  </xsl:template>
</xsl:stylesheet>
