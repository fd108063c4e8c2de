<?xml version="1.0" encoding="UTF-8"?>
<!-- SPDX-License-Identifier: BSD-2-Clause -->
<!-- For check.xsl: writes a finding as an element with its line, and the names in it. -->
<xsl:stylesheet version="1.0" xmlns:xsl="http://www.w3.org/1999/XSL/Transform"
                xmlns:t="urn:mlcca:table" exclude-result-prefixes="t">
  <!-- A line, with its parts in attributes. publisher, subscriber and hop are elements, or empty. -->
  <xsl:template name="finding">
    <xsl:param name="id"/>
    <xsl:param name="channel" select="/.."/>
    <xsl:param name="publisher" select="/.."/>
    <xsl:param name="subscriber" select="/.."/>
    <xsl:param name="hop" select="/.."/>
    <xsl:param name="row" select="/.."/>
    <xsl:param name="required"/>
    <xsl:param name="provided"/>
    <xsl:param name="text"/>
    <xsl:variable name="publisher-name"><xsl:apply-templates select="$publisher" mode="name"/></xsl:variable>
    <xsl:variable name="subscriber-name"><xsl:apply-templates select="$subscriber" mode="name"/></xsl:variable>
    <xsl:variable name="required-value"><xsl:call-template name="plain"><xsl:with-param name="value" select="$required"/></xsl:call-template></xsl:variable>
    <xsl:variable name="provided-value"><xsl:call-template name="plain"><xsl:with-param name="value" select="$provided"/></xsl:call-template></xsl:variable>
    <xsl:variable name="unit"><xsl:apply-templates select="$row" mode="unit"/></xsl:variable>
    <Finding id="{$id}">
      <xsl:if test="$channel"><xsl:attribute name="channel"><xsl:apply-templates select="$channel" mode="name"/></xsl:attribute></xsl:if>
      <xsl:if test="$publisher"><xsl:attribute name="publisher"><xsl:value-of select="$publisher-name"/></xsl:attribute></xsl:if>
      <xsl:if test="$subscriber"><xsl:attribute name="subscriber"><xsl:value-of select="$subscriber-name"/></xsl:attribute></xsl:if>
      <xsl:if test="$hop"><xsl:attribute name="hop"><xsl:value-of select="normalize-space($hop/@name)"/></xsl:attribute></xsl:if>
      <xsl:if test="$row">
        <xsl:attribute name="attribute"><xsl:value-of select="normalize-space($row/@name)"/></xsl:attribute>
        <xsl:attribute name="required"><xsl:value-of select="$required-value"/></xsl:attribute>
        <xsl:if test="$provided != ''"><xsl:attribute name="provided"><xsl:value-of select="$provided-value"/></xsl:attribute></xsl:if>
        <xsl:attribute name="unit"><xsl:value-of select="$unit"/></xsl:attribute>
      </xsl:if>
      <xsl:value-of select="concat('error ', $id, ': ')"/>
      <xsl:if test="$publisher"><xsl:value-of select="concat('publisher ', $publisher-name, ', ')"/></xsl:if>
      <xsl:if test="$subscriber"><xsl:value-of select="concat('subscriber ', $subscriber-name)"/></xsl:if>
      <xsl:if test="$hop"><xsl:value-of select="concat(', hop ', normalize-space($hop/@name))"/></xsl:if>
      <xsl:if test="$row">
        <xsl:value-of select="concat(', attribute ', normalize-space($row/@name), ': required ', $required-value, ' ', $unit, ', ')"/>
        <xsl:choose>
          <xsl:when test="$provided = ''">not provided</xsl:when>
          <xsl:when test="$provided = $unbounded">provided without a bound</xsl:when>
          <xsl:otherwise><xsl:value-of select="concat('provided ', $provided-value, ' ', $unit)"/></xsl:otherwise>
        </xsl:choose>
      </xsl:if>
      <xsl:if test="$subscriber and $text">: </xsl:if>
      <xsl:value-of select="concat($text, '&#10;')"/>
    </Finding>
  </xsl:template>

  <xsl:template name="left">
    <xsl:param name="publisher"/>
    <xsl:param name="subscriber"/>
    <xsl:param name="text"/>
    <xsl:variable name="publisher-name"><xsl:apply-templates select="$publisher" mode="name"/></xsl:variable>
    <xsl:variable name="subscriber-name"><xsl:apply-templates select="$subscriber" mode="name"/></xsl:variable>
    <Left id="MLCCA034" publisher="{$publisher-name}" subscriber="{$subscriber-name}">
      <xsl:value-of select="concat('note MLCCA034: publisher ', $publisher-name, ', subscriber ', $subscriber-name, ': ', $text, '&#10;')"/>
    </Left>
  </xsl:template>

  <!-- The current node is the network or gateway that states a Bandwidth. -->
  <xsl:template name="sum-left">
    <xsl:variable name="name" select="normalize-space(@name)"/>
    <Left id="MLCCA034" hop="{$name}" attribute="Bandwidth">
      <xsl:value-of select="concat('note MLCCA034: hop ', $name, ', attribute Bandwidth: what all channels need together is not added up: not decided here, left to mlccactl check&#10;')"/>
    </Left>
  </xsl:template>

  <!-- The note for every description, so that a missing finding is not taken for a result. -->
  <xsl:template name="rest-left">
    <Left id="MLCCA034">
      <xsl:text>note MLCCA034: identifiers, lengths of frames, traffic that must be stated, and what reaches others on a network are not decided here: left to mlccactl check&#10;</xsl:text>
    </Left>
  </xsl:template>

  <!-- The note on a requirement that only mlccactl check can compare with what it computes. -->
  <xsl:template name="undecided">
    <xsl:param name="publisher"/>
    <xsl:param name="subscriber"/>
    <xsl:param name="hop"/>
    <xsl:param name="row"/>
    <xsl:param name="required"/>
    <xsl:variable name="publisher-name"><xsl:apply-templates select="$publisher" mode="name"/></xsl:variable>
    <xsl:variable name="subscriber-name"><xsl:apply-templates select="$subscriber" mode="name"/></xsl:variable>
    <xsl:variable name="hop-name" select="normalize-space($hop/@name)"/>
    <xsl:variable name="name" select="normalize-space($row/@name)"/>
    <xsl:variable name="value"><xsl:call-template name="plain"><xsl:with-param name="value" select="$required"/></xsl:call-template></xsl:variable>
    <xsl:variable name="unit"><xsl:apply-templates select="$row" mode="unit"/></xsl:variable>
    <Undecided id="MLCCA034" publisher="{$publisher-name}" subscriber="{$subscriber-name}" hop="{$hop-name}" attribute="{$name}" required="{$value}" unit="{$unit}">
      <xsl:value-of select="concat('note MLCCA034: publisher ', $publisher-name, ', subscriber ', $subscriber-name, ', hop ', $hop-name, ', attribute ', $name, ': required ', $value, ' ', $unit, ', provided what is computed: not decided here, left to mlccactl check&#10;')"/>
    </Undecided>
  </xsl:template>

  <xsl:template match="t:attribute" mode="unit"><xsl:value-of select="@unit"/></xsl:template>
  <xsl:template match="UserAttribute" mode="unit">
    <xsl:variable name="magnitude"><xsl:call-template name="magnitude"><xsl:with-param name="of" select="."/></xsl:call-template></xsl:variable>
    <xsl:value-of select="concat('x 1e', $magnitude)"/>
    <xsl:for-each select="Dimension/SIUnit/*"><xsl:value-of select="concat(' ', local-name(), '^', normalize-space(.))"/></xsl:for-each>
  </xsl:template>

  <xsl:template match="EventChannel" mode="name">
    <xsl:value-of select="normalize-space(@name)"/>
    <xsl:if test="not(@name)">
      <xsl:apply-templates select="SubjectUID" mode="subject"/>
    </xsl:if>
  </xsl:template>

  <!-- The name of an end: by default channel@place or channel@component, with #2, #3 for further ones there. -->
  <xsl:template match="Publisher | Subscriber" mode="name">
    <xsl:variable name="subject"><xsl:apply-templates select="@channel[starts-with(normalize-space(), '0x')]" mode="subject"/></xsl:variable>
    <xsl:variable name="channel" select="key('channel', normalize-space(@channel)) | key('channel', $subject)"/>
    <xsl:choose>
      <xsl:when test="@name or not($channel)"><xsl:value-of select="normalize-space(@name)"/></xsl:when>
      <xsl:otherwise>
        <xsl:variable name="id" select="generate-id()"/>
        <xsl:variable name="component" select="generate-id(parent::Component)"/>
        <xsl:variable name="seat" select="normalize-space(concat(@network, @gateway))"/>
        <xsl:variable name="channels-subject"><xsl:apply-templates select="$channel/SubjectUID" mode="subject"/></xsl:variable>
        <xsl:variable name="name"><xsl:apply-templates select="$channel" mode="name"/></xsl:variable>
        <xsl:variable name="all" select="key('use-of', concat(local-name(), ' ', $name)) |
                                         key('use-of', concat(local-name(), ' ', $channels-subject))"/>
        <xsl:value-of select="concat($name, '@', normalize-space(parent::Component/@name))"/>
        <xsl:if test="not(parent::Component)"><xsl:value-of select="$seat"/></xsl:if>
        <xsl:for-each select="$all[not(@name)][generate-id(parent::Component) = $component and
                                               normalize-space(concat(@network, @gateway)) = $seat]">
          <xsl:if test="generate-id() = $id and position() &gt; 1"><xsl:value-of select="concat('#', position())"/></xsl:if>
        </xsl:for-each>
      </xsl:otherwise>
    </xsl:choose>
  </xsl:template>
</xsl:stylesheet>
