# SPDX-License-Identifier: BSD-2-Clause
# A recipe for a layer of yours (Yocto 5.0 "scarthgap" and later, with meta-openembedded and meta-clang). It was
# written from debian/control, debian/rules and packaging/mlcca.spec, and was not built: no bitbake was at hand.
# What is likely to need a change in your layer is marked by "CHECK".
SUMMARY = "Gateway that lets no data pass over a network that cannot carry it"
DESCRIPTION = "mlccad checks the requirements of event channels (latency, period, omission, bandwidth) against the \
networks on their route, and makes the kernel of a gateway drop what was not admitted."
LICENSE = "BSD-2-Clause & (GPL-2.0-only | BSD-2-Clause)"
LIC_FILES_CHKSUM = "file://LICENSE;md5=${LICENSE_MD5}"
# CHECK: md5sum LICENSE
LICENSE_MD5 ?= ""

# CHECK: where you keep the sources, and at which commit.
SRC_URI = "git://git.example.org/mlcca.git;protocol=https;branch=main"
SRCREV = "${AUTOREV}"
S = "${WORKDIR}/git"

# Of the target. libbpf 1.1 or later; protozero, fmt, cli11 and nlohmann-json are headers but for fmt.
DEPENDS = "libbpf elfutils zlib libnl sqlite3 systemd protobuf protozero libxml2 libyaml fmt cli11 nlohmann-json \
           libmicrohttpd curl"
# Of the build machine: clang makes the BPF programs, bpftool their skeletons, protoc and xsltproc what is generated.
DEPENDS += "clang-native llvm-native bpftool-native protobuf-native python3-protobuf-native libxslt-native"

inherit pkgconfig systemd useradd python3native

# The compiler must know C++23 (g++ 12 or later). MLCCACTL_STATIC=: shared libraries, as any package has them.
EXTRA_OEMAKE = "V=1 WERROR= BUNDLE=1 MLCCACTL_STATIC= O=${B}/build PREFIX=${prefix} LIBDIR=${libdir} \
    CXX='${CXX}' CLANG=clang LLVM_STRIP=llvm-strip PROTOC=protoc \
    PYTHON_DIR=${PYTHON_SITEPACKAGES_DIR} UNITDIR=${systemd_system_unitdir} UDEVDIR=${nonarch_base_libdir}/udev/rules.d"

do_compile() {
    oe_runmake all
}

do_install() {
    oe_runmake DESTDIR=${D} install
}

# Nothing is started before somebody has described something: enable mlccad in an image of yours, with its
# /etc/mlcca/system.xml (docs/how-to/container.md).
SYSTEMD_SERVICE:${PN} = "mlccad.service mlccad.socket mlcca-gate.service mlcca-relay.service"
SYSTEMD_AUTO_ENABLE:${PN} = "disable"

# As systemd/mlcca.sysusers has them, for images without systemd-sysusers.
USERADD_PACKAGES = "${PN}"
GROUPADD_PARAM:${PN} = "--system mlcca; --system mlcca-relay; --system mlcca-sources; --system mlcca-famouso"
USERADD_PARAM:${PN} = "--system --no-create-home --gid mlcca --shell /sbin/nologin mlcca; \
    --system --no-create-home --gid mlcca-relay --shell /sbin/nologin mlcca-relay; \
    --system --no-create-home --gid mlcca-sources --shell /sbin/nologin mlcca-sources; \
    --system --no-create-home --gid mlcca-famouso --shell /sbin/nologin mlcca-famouso"

PACKAGES =+ "libmlcca libmlcca-dev python3-mlcca cockpit-mlcca ${PN}-exporter ${PN}-cluster"
FILES:libmlcca = "${libdir}/libmlcca.so.*"
FILES:libmlcca-dev = "${includedir}/mlcca ${libdir}/libmlcca.so ${libdir}/pkgconfig/mlcca.pc ${libdir}/cmake/mlcca"
FILES:python3-mlcca = "${PYTHON_SITEPACKAGES_DIR}/mlcca"
FILES:cockpit-mlcca = "${datadir}/cockpit/mlcca"
FILES:${PN}-exporter = "${sbindir}/mlcca-exporter ${systemd_system_unitdir}/mlcca-exporter.* ${datadir}/mlcca-exporter"
FILES:${PN}-cluster = "${sbindir}/mlcca-cluster ${systemd_system_unitdir}/mlcca-cluster.*"
FILES:${PN} += "${datadir} ${libexecdir}/mlcca ${nonarch_libdir}/sysusers.d ${nonarch_libdir}/tmpfiles.d \
    ${nonarch_base_libdir}/udev/rules.d ${systemd_system_unitdir}"
CONFFILES:${PN} = "${sysconfdir}/mlcca"

RDEPENDS:python3-mlcca = "libmlcca python3-core python3-protobuf python3-asyncio"
RDEPENDS:${PN} = "iproute2"
# CAN and the gates need CONFIG_BPF_SYSCALL, CONFIG_BPF_JIT, CONFIG_NET_CLS_ACT, CONFIG_NET_CLS_BPF,
# CONFIG_NET_SCH_INGRESS, CONFIG_CAN, CONFIG_CAN_RAW and CONFIG_CAN_GW of Linux 6.1 or later.
RRECOMMENDS:${PN} = "kernel-module-can kernel-module-can-raw kernel-module-can-gw kernel-module-cls-bpf kernel-module-sch-ingress"
