<?xml version="1.0" encoding="UTF-8"?>
<!-- SPDX-License-Identifier: BSD-2-Clause -->
<!-- For check.xsl: notes on what a description may state but hardly means, as in core/sense.cc. -->
<xsl:stylesheet version="1.0" xmlns:xsl="http://www.w3.org/1999/XSL/Transform"
                xmlns:t="urn:mlcca:table" exclude-result-prefixes="t">
  <xsl:variable name="long-period" select="3600000000000"/> <!-- ns, an hour -->

  <!-- Examines the preferred attribute set. A channel gets at most one note of each kind. -->
  <xsl:template match="EventChannel" mode="sense"/>
  <xsl:template match="EventChannel[@safe-side]" mode="sense">
    <xsl:variable name="subject"><xsl:apply-templates select="SubjectUID" mode="subject"/></xsl:variable>
    <xsl:variable name="name" select="normalize-space(@name)"/>
    <xsl:variable name="publishers" select="key('use-of', concat('Publisher ', $name)) |
                                            key('use-of', concat('Publisher ', $subject))"/>
    <xsl:variable name="subscribers" select="key('use-of', concat('Subscriber ', $name)) |
                                             key('use-of', concat('Subscriber ', $subject))"/>
    <xsl:variable name="id">
      <xsl:for-each select="Attributes">
        <xsl:sort select="translate(@priority, '+', '')" data-type="number" order="descending"/>
        <xsl:if test="position() = 1"><xsl:value-of select="generate-id()"/></xsl:if>
      </xsl:for-each>
    </xsl:variable>
    <xsl:variable name="set" select="Attributes[generate-id() = $id]"/>
    <!-- The ids of the publishers and subscribers concerned, each after a blank. -->
    <xsl:variable name="silent">
      <xsl:if test="normalize-space(@safe-side) = 'drop'">
        <xsl:for-each select="$publishers">
          <xsl:variable name="publisher" select="."/>
          <xsl:for-each select="$subscribers">
            <xsl:variable name="period">
              <xsl:call-template name="stated-by"><xsl:with-param name="end" select="$publisher"/><xsl:with-param name="set" select="$set"/><xsl:with-param name="name" select="'Period'"/></xsl:call-template>
              <xsl:call-template name="stated-by"><xsl:with-param name="end" select="."/><xsl:with-param name="set" select="$set"/><xsl:with-param name="name" select="'Period'"/></xsl:call-template>
            </xsl:variable>
            <xsl:variable name="omission">
              <xsl:call-template name="stated-by"><xsl:with-param name="end" select="$publisher"/><xsl:with-param name="set" select="$set"/><xsl:with-param name="name" select="'Omission'"/></xsl:call-template>
              <xsl:call-template name="stated-by"><xsl:with-param name="end" select="."/><xsl:with-param name="set" select="$set"/><xsl:with-param name="name" select="'Omission'"/></xsl:call-template>
            </xsl:variable>
            <xsl:if test="string($period) and not(string($omission))">
              <xsl:value-of select="concat(' ', generate-id($publisher), ' ', generate-id(), ' ')"/>
            </xsl:if>
          </xsl:for-each>
        </xsl:for-each>
      </xsl:if>
    </xsl:variable>
    <xsl:if test="string($silent)">
      <xsl:variable name="first" select="substring-before(substring($silent, 2), ' ')"/>
      <xsl:variable name="second" select="substring-before(substring-after(substring($silent, 2), ' '), ' ')"/>
      <xsl:call-template name="sense">
        <xsl:with-param name="id" select="'MLCCA038'"/>
        <xsl:with-param name="publisher" select="$publishers[generate-id() = $first]"/>
        <xsl:with-param name="subscriber" select="$subscribers[generate-id() = $second]"/>
        <xsl:with-param name="attribute" select="'Omission'"/>
        <xsl:with-param name="text" select="'silence is the safe state, and nobody says how many events in a row may be lost'"/>
      </xsl:call-template>
    </xsl:if>
    <xsl:variable name="long">
      <xsl:for-each select="$publishers"><xsl:call-template name="if-long"><xsl:with-param name="set" select="$set"/></xsl:call-template></xsl:for-each>
      <xsl:for-each select="$subscribers"><xsl:call-template name="if-long"><xsl:with-param name="set" select="$set"/></xsl:call-template></xsl:for-each>
    </xsl:variable>
    <xsl:if test="string($long)">
      <xsl:variable name="first" select="substring-before(substring($long, 2), ' ')"/>
      <xsl:call-template name="sense">
        <xsl:with-param name="id" select="'MLCCA039'"/>
        <xsl:with-param name="publisher" select="$publishers[generate-id() = $first]"/>
        <xsl:with-param name="subscriber" select="$subscribers[generate-id() = $first]"/>
        <xsl:with-param name="attribute" select="'Period'"/>
        <xsl:with-param name="text" select="'an hour or more lies between events on which safety depends'"/>
      </xsl:call-template>
    </xsl:if>
  </xsl:template>

  <!-- The id of the current publisher or subscriber between blanks, if its Period is long. -->
  <xsl:template name="if-long">
    <xsl:param name="set"/>
    <xsl:variable name="period">
      <xsl:call-template name="stated-by"><xsl:with-param name="end" select="."/><xsl:with-param name="set" select="$set"/><xsl:with-param name="name" select="'Period'"/></xsl:call-template>
    </xsl:variable>
    <xsl:if test="string($period) and string($period) != $unbounded and number($period) &gt;= $long-period">
      <xsl:value-of select="concat(' ', generate-id(), ' ')"/>
    </xsl:if>
  </xsl:template>

  <xsl:template name="stated-by">
    <xsl:param name="end"/>
    <xsl:param name="set"/>
    <xsl:param name="name"/>
    <xsl:call-template name="required-by">
      <xsl:with-param name="end" select="$end"/>
      <xsl:with-param name="set" select="$set"/>
      <xsl:with-param name="row" select="$table[@name = $name]"/>
    </xsl:call-template>
  </xsl:template>

  <xsl:template match="Port" mode="sense">
    <xsl:variable name="managed" select="normalize-space(@managed)"/>
    <xsl:variable name="network" select="key('place', normalize-space(@network))"/>
    <xsl:if test="($managed = 'true' or $managed = '1') and normalize-space($network/Kind) != 'can'">
      <xsl:call-template name="sense">
        <xsl:with-param name="id" select="'MLCCA040'"/>
        <xsl:with-param name="port" select="."/>
        <xsl:with-param name="text" select="'the port is managed, and its network is no CAN network'"/>
      </xsl:call-template>
    </xsl:if>
    <xsl:variable name="is-can" select="normalize-space($network/Kind) = 'can'"/>
    <xsl:variable name="forward" select="normalize-space(../@forward)"/>
    <xsl:variable name="relays" select="$forward = '' or $forward = 'relay'"/>
    <xsl:variable name="own" select="normalize-space(@network)"/>
    <xsl:variable name="carried">
      <xsl:for-each select="../Port[normalize-space(@network) != $own]">
        <xsl:variable name="from-can" select="normalize-space(key('place', normalize-space(@network))/Kind) = 'can'"/>
        <xsl:if test="$from-can != $is-can or ($relays and not($is-can))">1</xsl:if>
      </xsl:for-each>
    </xsl:variable>
    <xsl:if test="@sender and string($carried)">
      <xsl:call-template name="sense">
        <xsl:with-param name="id" select="'MLCCA041'"/>
        <xsl:with-param name="port" select="."/>
        <xsl:with-param name="text" select="'a program carries the events, and mlccad does not start it'"/>
      </xsl:call-template>
    </xsl:if>
  </xsl:template>

  <xsl:template name="sense">
    <xsl:param name="id"/>
    <xsl:param name="publisher" select="/.."/>
    <xsl:param name="subscriber" select="/.."/>
    <xsl:param name="port" select="/.."/>
    <xsl:param name="attribute"/>
    <xsl:param name="text"/>
    <xsl:variable name="publisher-name"><xsl:apply-templates select="$publisher" mode="name"/></xsl:variable>
    <xsl:variable name="subscriber-name"><xsl:apply-templates select="$subscriber" mode="name"/></xsl:variable>
    <Note id="{$id}">
      <xsl:if test="$publisher"><xsl:attribute name="publisher"><xsl:value-of select="$publisher-name"/></xsl:attribute></xsl:if>
      <xsl:if test="$subscriber"><xsl:attribute name="subscriber"><xsl:value-of select="$subscriber-name"/></xsl:attribute></xsl:if>
      <xsl:if test="$attribute"><xsl:attribute name="attribute"><xsl:value-of select="$attribute"/></xsl:attribute></xsl:if>
      <xsl:if test="$port">
        <xsl:attribute name="gateway"><xsl:value-of select="normalize-space($port/../@name)"/></xsl:attribute>
        <xsl:attribute name="network"><xsl:value-of select="normalize-space($port/@network)"/></xsl:attribute>
      </xsl:if>
      <xsl:value-of select="concat('note ', $id, ': ')"/>
      <xsl:if test="$publisher"><xsl:value-of select="concat('publisher ', $publisher-name, ', ')"/></xsl:if>
      <xsl:if test="$subscriber"><xsl:value-of select="concat('subscriber ', $subscriber-name, ', ')"/></xsl:if>
      <xsl:if test="$attribute"><xsl:value-of select="concat('attribute ', $attribute)"/></xsl:if>
      <xsl:if test="$port"><xsl:value-of select="concat('gateway ', normalize-space($port/../@name), ', network ', normalize-space($port/@network))"/></xsl:if>
      <xsl:value-of select="concat(': ', $text, '&#10;')"/>
    </Note>
  </xsl:template>
</xsl:stylesheet>
