<?xml version="1.0" encoding="UTF-8"?>
<!-- SPDX-License-Identifier: BSD-2-Clause -->
<!--
  The second half of the manual page mlcca-system(5), from the schema: the content of each element, its
  attributes and their values. docs/man/mlcca-system.5.in is the first half.

      xsltproc man.xsl system.xsd | cat ../docs/man/mlcca-system.5.in - > mlcca-system.5
-->
<xsl:stylesheet version="1.0" xmlns:xsl="http://www.w3.org/1999/XSL/Transform"
                xmlns:xs="http://www.w3.org/2001/XMLSchema" xmlns:str="http://exslt.org/strings"
                extension-element-prefixes="str" exclude-result-prefixes="xs">
  <!-- The words for orders, numbers and values are those of the HTML page. -->
  <xsl:import href="reference.xsl"/>
  <xsl:output method="text" encoding="UTF-8"/>
  <xsl:key name="of-type" match="xs:element" use="@type"/>

  <xsl:template match="/xs:schema">
    <xsl:text>.SH ELEMENTS&#10;</xsl:text>
    <xsl:apply-templates select="xs:complexType" mode="part"/>
    <!-- Patterns are long words, so lines are not adjusted (.na). -->
    <xsl:text>.SH VALUES&#10;.na&#10;White space around a value does not count.&#10;</xsl:text>
    <xsl:for-each select="xs:simpleType">
      <xsl:sort select="@name"/>
      <xsl:variable name="words"><xsl:apply-templates select="." mode="words"/></xsl:variable>
      <xsl:call-template name="entry"><xsl:with-param name="name" select="@name"/></xsl:call-template>
      <xsl:call-template name="line"><xsl:with-param name="text" select="$words"/></xsl:call-template>
    </xsl:for-each>
    <xsl:text>.TP&#10;.B boolean&#10;true or 1, false or 0&#10;.ad&#10;</xsl:text>
    <xsl:text>.SH INCLUDED FILES AND LIMITS&#10;</xsl:text>
    <!-- The first paragraph is left out, because the first half of the page says the same. -->
    <xsl:call-template name="lines">
      <xsl:with-param name="text" select="substring-after(xs:annotation/xs:documentation, '&#10;&#10;')"/>
    </xsl:call-template>
    <xsl:text>.SH SEE ALSO&#10;.BR mlccactl (1),&#10;.BR mlccactl\-describe (1),&#10;.BR mlccactl\-new (1),&#10;</xsl:text>
    <xsl:text>.BR mlccad (8)&#10;.PP&#10;</xsl:text>
    <xsl:text>The schema is share/mlcca/system.xsd; share/doc/mlcca/reference.html has the same with examples.&#10;</xsl:text>
  </xsl:template>

  <xsl:template match="xs:complexType" mode="part">
    <xsl:variable name="type" select="@name"/>
    <xsl:text>.SS </xsl:text>
    <xsl:value-of select="@name"/>
    <!-- MeshNode is the type of Node. -->
    <xsl:for-each select="key('of-type', @name)[@name != $type][1]">
      <xsl:value-of select="concat(' (element ', @name, ')')"/>
    </xsl:for-each>
    <xsl:text>&#10;</xsl:text>
    <xsl:apply-templates select="xs:annotation" mode="man"/>
    <xsl:variable name="content" select="xs:sequence | xs:choice | xs:all | xs:group"/>
    <xsl:choose>
      <xsl:when test="xs:simpleContent">
        <xsl:value-of select="concat('Its value is of type ', .//xs:extension/@base, '.&#10;')"/>
      </xsl:when>
      <xsl:when test="$content">
        <xsl:text>Holds </xsl:text>
        <xsl:apply-templates select="$content" mode="order"/>
        <xsl:text>&#10;</xsl:text>
        <xsl:apply-templates select="$content//xs:element | key('group', xs:group/@ref)//xs:element" mode="part"/>
        <xsl:if test="$content//xs:any">
          <xsl:text>.TP&#10;.B xi:include&#10;Another file, whose root is one of these.&#10;</xsl:text>
        </xsl:if>
      </xsl:when>
      <xsl:otherwise><xsl:text>Has no content.&#10;</xsl:text></xsl:otherwise>
    </xsl:choose>
    <xsl:variable name="attributes" select="xs:attribute | xs:attributeGroup | xs:simpleContent/xs:extension/xs:attribute"/>
    <xsl:if test="$attributes">
      <xsl:text>.PP&#10;Attributes:&#10;</xsl:text>
      <xsl:apply-templates select="$attributes" mode="part"/>
    </xsl:if>
  </xsl:template>

  <xsl:template match="xs:element" mode="part">
    <xsl:variable name="count">
      <xsl:choose>
        <xsl:when test="parent::xs:choice/parent::xs:sequence">, in any order and number</xsl:when>
        <xsl:when test="parent::xs:choice"/>
        <xsl:when test="parent::xs:sequence[@minOccurs = 0]">, at most one</xsl:when>
        <xsl:otherwise>, <xsl:apply-templates select="." mode="count"/></xsl:otherwise>
      </xsl:choose>
    </xsl:variable>
    <xsl:call-template name="entry">
      <xsl:with-param name="name" select="@name"/>
      <xsl:with-param name="about" select="concat(substring(@type, 1 + 3 * starts-with(@type, 'xs:')), $count)"/>
    </xsl:call-template>
    <xsl:apply-templates select="xs:annotation" mode="man"/>
  </xsl:template>

  <xsl:template match="xs:attributeGroup" mode="part"><xsl:apply-templates select="key('group', @ref)/*" mode="part"/></xsl:template>

  <xsl:template match="xs:attribute" mode="part">
    <xsl:variable name="use">
      <xsl:choose>
        <xsl:when test="@use = 'required'">, required</xsl:when>
        <xsl:when test="@default"><xsl:value-of select="concat(', default ', @default)"/></xsl:when>
      </xsl:choose>
    </xsl:variable>
    <xsl:call-template name="entry">
      <xsl:with-param name="name" select="@name"/>
      <xsl:with-param name="about" select="concat(substring(@type, 1 + 3 * starts-with(@type, 'xs:')), $use)"/>
    </xsl:call-template>
    <xsl:apply-templates select="xs:annotation" mode="man"/>
  </xsl:template>

  <!-- ============================ roff ============================ -->

  <!-- ".B name" with its properties in brackets; the text after it is indented. -->
  <xsl:template name="entry">
    <xsl:param name="name"/>
    <xsl:param name="about"/>
    <xsl:text>.TP&#10;</xsl:text>
    <xsl:value-of select="concat('.B ', str:replace($name, '-', '\-'))"/>
    <xsl:if test="$about"><xsl:value-of select="concat(' \fR(', str:replace($about, '-', '\-'), ')\fP')"/></xsl:if>
    <xsl:text>&#10;</xsl:text>
  </xsl:template>

  <xsl:template match="xs:annotation" mode="man">
    <xsl:call-template name="lines"><xsl:with-param name="text" select="string(xs:documentation)"/></xsl:call-template>
  </xsl:template>

  <!-- Paragraphs are separated by empty lines. -->
  <xsl:template name="lines">
    <xsl:param name="text"/>
    <xsl:if test="normalize-space($text)">
      <xsl:call-template name="line">
        <xsl:with-param name="text" select="substring-before(concat($text, '&#10;&#10;'), '&#10;&#10;')"/>
      </xsl:call-template>
      <xsl:variable name="rest" select="substring-after($text, '&#10;&#10;')"/>
      <xsl:if test="normalize-space($rest)">
        <xsl:text>.PP&#10;</xsl:text>
        <xsl:call-template name="lines"><xsl:with-param name="text" select="$rest"/></xsl:call-template>
      </xsl:if>
    </xsl:if>
  </xsl:template>

  <!-- A line that would begin with a full stop is no request. A sentence a line, as roff wants it. A pattern may be
       broken behind each of its parts. -->
  <xsl:template name="line">
    <xsl:param name="text"/>
    <xsl:variable name="plain" select="str:replace(str:replace(str:replace(normalize-space($text), '\', '\e'), '-', '\-'), '|', '|\:')"/>
    <xsl:value-of select="concat('\&amp;', str:replace($plain, '. ', '.&#10;\&amp;'), '&#10;')"/>
  </xsl:template>
</xsl:stylesheet>
