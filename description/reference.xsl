<?xml version="1.0" encoding="UTF-8"?>
<!-- SPDX-License-Identifier: BSD-2-Clause -->
<!--
  The reference of the format from its schema: one HTML page without scripts and without anything that
  is loaded from elsewhere.

      xsltproc reference.xsl system.xsd > reference.html

  The table below adds what the schema does not have: examples, which are parts of real descriptions.
-->
<xsl:stylesheet version="1.0" xmlns:xsl="http://www.w3.org/1999/XSL/Transform"
                xmlns:xs="http://www.w3.org/2001/XMLSchema" xmlns:r="urn:mlcca:reference"
                exclude-result-prefixes="xs r">
  <xsl:output method="html" encoding="UTF-8" indent="no" doctype-system="about:legacy-compat"/>


  <r:example type="System" file="volksbot/robot" element="System"/>
  <r:example type="EventChannel" file="volksbot/channels/emergency-switch" element="EventChannel"/>
  <r:example type="Attributes" file="volksbot/channels/video" element="Attributes"/>
  <r:example type="Network" file="volksbot/networks/operator-can" element="Network"/>
  <r:example type="Bus" file="volksbot/networks/operator-can" element="Bus"/>
  <r:example type="Mesh" file="mesh/system" element="Mesh"/>
  <r:example type="Provision" file="volksbot/networks/awds" element="Provision"/>
  <r:example type="Gateway" file="volksbot/gateways/laptop" element="Gateway"/>
  <r:example type="Component" file="volksbot/components/control" element="Component"/>
  <r:example type="Placement" file="volksbot/second-bus" element="Placement"/>
  <r:example type="Route" file="volksbot/second-bus" element="Route"/>

  <xsl:variable name="examples" select="document('')/xsl:stylesheet/r:example"/>
  <xsl:key name="type" match="xs:complexType | xs:simpleType" use="@name"/>
  <xsl:key name="group" match="xs:group[@name] | xs:attributeGroup[@name]" use="@name"/>
  <xsl:key name="element" match="xs:element" use="@name"/>
  <xsl:key name="attribute" match="xs:attribute" use="@name"/>

  <xsl:template match="/xs:schema">
    <html lang="en">
      <head>
        <meta name="viewport" content="width=device-width, initial-scale=1"/>
        <title>MLCCA: the system description</title>
        <style>
          :root { color-scheme: light dark; --ink: #1c2024; --paper: #fff; --faint: #f3f4f6; --line: #d5d9de; --link: #0b57a4; }
          @media (prefers-color-scheme: dark) {
            :root { --ink: #e4e6e8; --paper: #16181b; --faint: #22262a; --line: #3a4047; --link: #8ab8f0; }
          }
          body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: var(--ink); background: var(--paper); }
          a { color: var(--link); }
          code, pre { font-family: ui-monospace, monospace; font-size: 0.9em; }
          pre { background: var(--faint); padding: 0.7rem 1rem; overflow-x: auto; }
          .part { border-top: 1px solid var(--line); margin-top: 2rem; }
          table { border-collapse: collapse; width: 100%; }
          th, td { text-align: left; vertical-align: top; border-bottom: 1px solid var(--line); padding: 0.3rem 0.6rem 0.3rem 0; }
          .index { columns: 14rem; list-style: none; padding: 0; }
          .count { font-style: italic; }
          @media print {
            :root { --ink: #000; --paper: #fff; --faint: #fff; --line: #999; --link: #000; }
            body { max-width: none; margin: 0; font-size: 10pt; }
            .part, tr, pre { break-inside: avoid; }
            pre { border: 1px solid var(--line); white-space: pre-wrap; }
          }
        </style>
      </head>
      <body>
        <h1>The system description</h1>
        <xsl:apply-templates select="xs:annotation"/>
        <h2 id="roots">Roots</h2>
        <p>
          The root of a description is <a href="#System"><code>System</code></a>. Files that are included have one of these:
          <xsl:for-each select="xs:element[@name != 'System']">
            <a href="#{@type}"><code><xsl:value-of select="@name"/></code></a>
            <xsl:if test="position() != last()">, </xsl:if>
          </xsl:for-each>.
        </p>
        <h2 id="elements">Elements</h2>
        <ul class="index">
          <xsl:for-each select="//xs:element[generate-id() = generate-id(key('element', @name)[1])]">
            <xsl:sort select="@name"/>
            <li><xsl:apply-templates select="." mode="index"/></li>
          </xsl:for-each>
        </ul>
        <h2 id="attributes">Attributes</h2>
        <ul class="index">
          <xsl:for-each select="//xs:attribute[generate-id() = generate-id(key('attribute', @name)[1])]">
            <xsl:sort select="@name"/>
            <li>
              <code><xsl:value-of select="@name"/></code>
              <xsl:variable name="name" select="@name"/>
              <xsl:variable name="in-groups" select="key('attribute', @name)/ancestor::xs:attributeGroup"/>
              <!-- A group of attributes may contain another one. -->
              <xsl:variable name="groups" select="$in-groups | //xs:attributeGroup[@name][xs:attributeGroup/@ref = $in-groups/@name]"/>
              <xsl:for-each select="//xs:complexType[.//xs:attribute/@name = $name or .//xs:attributeGroup/@ref = $groups/@name]">
                <xsl:choose>
                  <xsl:when test="position() = 1"> of </xsl:when>
                  <xsl:otherwise>, </xsl:otherwise>
                </xsl:choose>
                <a href="#{@name}"><xsl:value-of select="@name"/></a>
              </xsl:for-each>
            </li>
          </xsl:for-each>
        </ul>
        <h2 id="contents">What elements hold</h2>
        <xsl:apply-templates select="xs:complexType"/>
        <h2 id="values">Values</h2>
        <p>White space around a value does not count, and several spaces within it count as one.</p>
        <table>
          <tr><th>type</th><th>values</th></tr>
          <xsl:for-each select="xs:simpleType">
            <xsl:sort select="@name"/>
            <tr id="{@name}">
              <td><code><xsl:value-of select="@name"/></code></td>
              <td><xsl:apply-templates select="." mode="words"/></td>
            </tr>
          </xsl:for-each>
          <tr id="boolean"><td><code>boolean</code></td><td><code>true</code> or <code>1</code>, <code>false</code> or <code>0</code></td></tr>
        </table>
      </body>
    </html>
  </xsl:template>

  <!-- Where the reference describes an element: by itself, or as a value within others. -->
  <xsl:template match="xs:element" mode="index">
    <code><xsl:value-of select="@name"/></code>
    <xsl:variable name="name" select="@name"/>
    <xsl:variable name="groups" select="key('element', @name)/ancestor::xs:group/@name"/>
    <xsl:for-each select="//xs:complexType[.//xs:element/@name = $name or xs:group/@ref = $groups]">
      <xsl:choose>
        <xsl:when test="position() = 1"> in </xsl:when>
        <xsl:otherwise>, </xsl:otherwise>
      </xsl:choose>
      <a href="#{@name}-{$name}"><xsl:value-of select="@name"/></a>
    </xsl:for-each>
    <xsl:if test="@name = 'System'"><xsl:text>, </xsl:text><a href="#System">the root</a></xsl:if>
  </xsl:template>

  <!-- ============================ text ============================ -->

  <!-- Paragraphs are separated by empty lines. -->
  <xsl:template match="xs:annotation">
    <xsl:call-template name="paragraphs"><xsl:with-param name="text" select="string(xs:documentation)"/></xsl:call-template>
  </xsl:template>

  <xsl:template name="paragraphs">
    <xsl:param name="text"/>
    <xsl:if test="normalize-space($text)">
      <p><xsl:value-of select="normalize-space(substring-before(concat($text, '&#10;&#10;'), '&#10;&#10;'))"/></p>
      <xsl:call-template name="paragraphs">
        <xsl:with-param name="text" select="substring-after($text, '&#10;&#10;')"/>
      </xsl:call-template>
    </xsl:if>
  </xsl:template>

  <!-- ============================ what elements hold ============================ -->

  <xsl:template match="xs:complexType">
    <xsl:variable name="name" select="@name"/>
    <div class="part" id="{@name}">
      <h3><xsl:value-of select="@name"/></h3>
      <xsl:apply-templates select="xs:annotation"/>
      <xsl:variable name="content" select="xs:sequence | xs:choice | xs:all | xs:group"/>
      <xsl:choose>
        <xsl:when test="xs:simpleContent">
          <p>Its value is <xsl:apply-templates select=".//xs:extension/@base" mode="link"/>.</p>
        </xsl:when>
        <xsl:when test="$content">
          <p>Holds <xsl:apply-templates select="$content" mode="order"/></p>
          <ul>
            <xsl:apply-templates select="$content" mode="content">
              <xsl:with-param name="holder" select="@name"/>
            </xsl:apply-templates>
          </ul>
        </xsl:when>
        <xsl:otherwise><p>Has no content.</p></xsl:otherwise>
      </xsl:choose>
      <xsl:variable name="attributes" select="xs:attribute | xs:attributeGroup | xs:simpleContent/xs:extension/xs:attribute"/>
      <xsl:if test="$attributes">
        <table>
          <tr><th>attribute</th><th>value</th><th></th><th></th></tr>
          <xsl:apply-templates select="$attributes"/>
        </table>
      </xsl:if>
      <xsl:for-each select="$examples[@type = $name]">
        <xsl:variable name="element" select="@element"/>
        <!-- A part keeps the indentation of its file. -->
        <xsl:variable name="part" select="document(concat('../examples/', @file, '.xml'))//*[local-name() = $element][last()]"/>
        <pre>
          <xsl:value-of select="translate($part/preceding-sibling::node()[1]/self::text(), '&#10;', '')"/>
          <xsl:apply-templates select="$part" mode="source"/>
        </pre>
      </xsl:for-each>
    </div>
  </xsl:template>

  <xsl:template match="xs:sequence" mode="order">in this order:</xsl:template>
  <xsl:template match="xs:all" mode="order">in any order:</xsl:template>
  <xsl:template match="xs:choice" mode="order">one of:</xsl:template>
  <xsl:template match="xs:choice[@maxOccurs = 'unbounded']" mode="order">in any order and number:</xsl:template>
  <xsl:template match="xs:group" mode="order"><xsl:apply-templates select="key('group', @ref)/*" mode="order"/></xsl:template>

  <xsl:template match="xs:sequence | xs:choice | xs:all | xs:group" mode="content">
    <xsl:param name="holder"/>
    <xsl:apply-templates select="*[not(self::xs:annotation)] | key('group', @ref)/*" mode="content">
      <xsl:with-param name="holder" select="$holder"/>
    </xsl:apply-templates>
  </xsl:template>
  <!-- Within another group they are on a line of their own. -->
  <xsl:template match="xs:sequence/xs:sequence | xs:sequence/xs:choice" mode="content">
    <xsl:param name="holder"/>
    <li>
      <xsl:if test="not(@maxOccurs)"><xsl:apply-templates select="." mode="count"/>, </xsl:if>
      <xsl:apply-templates select="." mode="order"/>
      <ul>
        <xsl:apply-templates select="*" mode="content">
          <xsl:with-param name="holder" select="$holder"/>
        </xsl:apply-templates>
      </ul>
    </li>
  </xsl:template>

  <xsl:template match="xs:element" mode="content">
    <xsl:param name="holder"/>
    <li id="{$holder}-{@name}">
      <code><xsl:value-of select="@name"/></code>
      <xsl:text>: </xsl:text>
      <xsl:apply-templates select="@type" mode="link"/>
      <xsl:if test="not(parent::xs:choice)">
        <xsl:text>, </xsl:text>
        <span class="count"><xsl:apply-templates select="." mode="count"/></span>
      </xsl:if>
      <xsl:apply-templates select="xs:annotation"/>
    </li>
  </xsl:template>

  <xsl:template match="xs:any" mode="content">
    <li><code>xi:include</code>: another file, whose root is one of these</li>
  </xsl:template>

  <xsl:template match="*" mode="count">
    <xsl:variable name="optional" select="@minOccurs = 0"/>
    <xsl:choose>
      <xsl:when test="@maxOccurs = 'unbounded' and $optional">any number</xsl:when>
      <xsl:when test="@maxOccurs = 'unbounded'">one or more</xsl:when>
      <xsl:when test="@maxOccurs">up to <xsl:value-of select="@maxOccurs"/></xsl:when>
      <xsl:when test="$optional">at most one</xsl:when>
      <xsl:otherwise>exactly one</xsl:otherwise>
    </xsl:choose>
  </xsl:template>

  <xsl:template match="xs:attributeGroup"><xsl:apply-templates select="key('group', @ref)/*"/></xsl:template>

  <xsl:template match="xs:attribute">
    <tr>
      <td><code><xsl:value-of select="@name"/></code></td>
      <td><xsl:apply-templates select="@type" mode="link"/></td>
      <td>
        <xsl:choose>
          <xsl:when test="@use = 'required'">required</xsl:when>
          <xsl:when test="@default">default <code><xsl:value-of select="@default"/></code></xsl:when>
          <xsl:otherwise>optional</xsl:otherwise>
        </xsl:choose>
      </td>
      <td><xsl:apply-templates select="xs:annotation"/></td>
    </tr>
  </xsl:template>

  <!-- The name of a type, as a link to its description further down. -->
  <xsl:template match="@*" mode="link">
    <xsl:variable name="name" select="substring(., 1 + 3 * starts-with(., 'xs:'))"/>
    <a href="#{$name}"><xsl:value-of select="$name"/></a>
  </xsl:template>

  <!-- ============================ values in words ============================ -->

  <xsl:template match="xs:simpleType" mode="words">
    <xsl:variable name="restriction" select="xs:restriction"/>
    <xsl:choose>
      <xsl:when test="$restriction/xs:enumeration">
        <xsl:for-each select="$restriction/xs:enumeration">
          <code><xsl:value-of select="@value"/></code>
          <xsl:if test="position() &lt; last() - 1">, </xsl:if>
          <xsl:if test="position() = last() - 1"> or </xsl:if>
        </xsl:for-each>
      </xsl:when>
      <xsl:when test="$restriction/xs:minInclusive">
        <xsl:text>a whole number</xsl:text>
        <xsl:for-each select="xs:annotation/xs:appinfo[@source = 'unit']"><xsl:value-of select="concat(' of ', .)"/></xsl:for-each>
        <xsl:value-of select="concat(' from ', $restriction/xs:minInclusive/@value)"/>
        <xsl:for-each select="xs:annotation/xs:appinfo[@source = 'least']"><xsl:value-of select="concat(' (', ., ')')"/></xsl:for-each>
        <xsl:value-of select="concat(' to ', $restriction/xs:maxInclusive/@value)"/>
      </xsl:when>
      <xsl:when test="xs:annotation/xs:appinfo[@source = 'range']">
        <xsl:value-of select="concat('a decimal number from ', xs:annotation/xs:appinfo[@source = 'range'],
                                     ', rounded ', xs:annotation/xs:appinfo[@source = 'rounded'], ' behind the point')"/>
      </xsl:when>
      <xsl:when test="$restriction/xs:minLength">
        <xsl:value-of select="concat($restriction/xs:minLength/@value, ' to ', $restriction/xs:maxLength/@value, ' characters')"/>
      </xsl:when>
      <xsl:when test="$restriction/xs:maxLength">
        <xsl:value-of select="concat('up to ', $restriction/xs:maxLength/@value, ' characters')"/>
      </xsl:when>
      <xsl:otherwise><xsl:value-of select="normalize-space(xs:annotation/xs:documentation)"/></xsl:otherwise>
    </xsl:choose>
    <xsl:if test="$restriction/xs:pattern"> (<code><xsl:value-of select="$restriction/xs:pattern/@value"/></code>)</xsl:if>
  </xsl:template>

  <!-- ============================ examples as text ============================ -->

  <xsl:template match="*" mode="source">
    <xsl:value-of select="concat('&lt;', name())"/>
    <xsl:if test="not(parent::*) and namespace::xi"><xsl:value-of select="concat(' xmlns:xi=&quot;', namespace::xi, '&quot;')"/></xsl:if>
    <xsl:for-each select="@*"><xsl:value-of select="concat(' ', name(), '=&quot;', ., '&quot;')"/></xsl:for-each>
    <xsl:choose>
      <xsl:when test="node()">
        <xsl:text>&gt;</xsl:text>
        <xsl:apply-templates select="node()" mode="source"/>
        <xsl:value-of select="concat('&lt;/', name(), '&gt;')"/>
      </xsl:when>
      <xsl:otherwise>/&gt;</xsl:otherwise>
    </xsl:choose>
  </xsl:template>
  <xsl:template match="comment()" mode="source">&lt;!--<xsl:value-of select="."/>--&gt;</xsl:template>
</xsl:stylesheet>
