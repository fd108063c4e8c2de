<?xml version="1.0" encoding="UTF-8"?>
<!-- SPDX-License-Identifier: BSD-2-Clause -->
<!-- A schema that has one element more than system.xsd, with types of each kind, and another default. -->
<xsl:stylesheet version="1.0" xmlns:xsl="http://www.w3.org/1999/XSL/Transform"
                xmlns:xs="http://www.w3.org/2001/XMLSchema">
  <xsl:template match="@* | node()"><xsl:copy><xsl:apply-templates select="@* | node()"/></xsl:copy></xsl:template>

  <xsl:template match="xs:complexType[@name = 'Gateway']/xs:sequence">
    <xsl:copy>
      <xsl:apply-templates/>
      <xs:element name="Location" type="Location" minOccurs="0" maxOccurs="2"/>
    </xsl:copy>
  </xsl:template>

  <xsl:template match="xs:attribute[@name = 'hops']/@default"><xsl:attribute name="default">5</xsl:attribute></xsl:template>

  <xsl:template match="/xs:schema">
    <xsl:copy>
      <xsl:apply-templates select="@* | node()"/>
      <xs:complexType name="Location">
        <xs:sequence>
          <xs:element name="Access" type="Access"/>
        </xs:sequence>
        <xs:attribute name="room" type="Room" use="required"/>
        <xs:attribute name="floor" type="Floor"/>
      </xs:complexType>
      <xs:simpleType name="Access">
        <xs:restriction base="xs:token">
          <xs:enumeration value="open"/>
          <xs:enumeration value="locked"/>
        </xs:restriction>
      </xs:simpleType>
      <xs:simpleType name="Room">
        <xs:annotation>
          <xs:documentation>a wing and a number, such as B-12, or hall</xs:documentation>
        </xs:annotation>
        <xs:restriction base="xs:token">
          <xs:pattern value="[A-D](-[0-9]{{1,2}}){{1,2}}|hall"/>
        </xs:restriction>
      </xs:simpleType>
      <xs:simpleType name="Floor">
        <xs:annotation>
          <xs:appinfo source="unit">floors</xs:appinfo>
        </xs:annotation>
        <xs:restriction base="xs:integer">
          <xs:minInclusive value="-2"/>
          <xs:maxInclusive value="40"/>
        </xs:restriction>
      </xs:simpleType>
    </xsl:copy>
  </xsl:template>
</xsl:stylesheet>
