// SPDX-License-Identifier: BSD-2-Clause
#include "cluster/settings.hpp"

#include <gtest/gtest.h>

#include "cluster/store_members.hpp"
#include "tests/cluster/processes.hpp"

namespace mlcca::cluster {
namespace {

Result<Settings> parsed(std::string_view text) { return parse_settings(text, "c.conf", "/keys"); }

TEST(ClusterSettings, EndpointsAreKeptInOrderAndTheRestHasDefaults) {
  const auto settings = parsed(
      "# the members\n\n endpoint=https://10.0.0.1:2380 # first\nendpoint = https://[fd00::1]\n"
      "endpoint = https://etcd-3.example\n");
  ASSERT_TRUE(settings.has_value()) << settings.error().text;
  EXPECT_EQ(settings->endpoints,
            (std::vector<std::string>{"https://10.0.0.1:2380", "https://[fd00::1]:2379",
                                      "https://etcd-3.example:2379"}));
  EXPECT_EQ(settings->ca, "/keys/ca.pem");
  EXPECT_EQ(settings->certificate, "/keys/cert.pem");
  EXPECT_EQ(settings->key, "/keys/key.pem");
  EXPECT_EQ(settings->timeout_ms, 1000U);
}

TEST(ClusterSettings, FilesAndTimeoutCanBeStated) {
  const auto settings =
      parsed("endpoint = https://a\nca = /a\ncertificate=/b\nkey = /c\ntimeout = 300");
  ASSERT_TRUE(settings.has_value()) << settings.error().text;
  EXPECT_EQ(settings->ca + settings->certificate + settings->key, "/a/b/c");
  EXPECT_EQ(settings->timeout_ms, 300U);
}

struct Wrong {
  const char* name;
  std::string text;
  std::string words;
};

class ClusterSettingsWrong : public ::testing::TestWithParam<Wrong> {};

TEST_P(ClusterSettingsWrong, IsNamedByFileAndLine) {
  const auto settings = parsed(GetParam().text);
  ASSERT_FALSE(settings.has_value());
  EXPECT_EQ(settings.error().text, GetParam().words);
}

INSTANTIATE_TEST_SUITE_P(
    All, ClusterSettingsWrong,
    ::testing::Values(
        Wrong{"Nothing", "", "c.conf: no endpoint is stated"},
        Wrong{"NoTls", "\nendpoint = http://a\n",
              "c.conf:2: the store is reached by TLS alone: https:// and a client certificate"},
        Wrong{"Path", "endpoint = https://a/b",
              "c.conf:1: 'https://a/b' is not https://HOST or https://HOST:PORT"},
        Wrong{"User", "endpoint = https://u@a",
              "c.conf:1: 'https://u@a' is not https://HOST or https://HOST:PORT"},
        Wrong{"Port", "endpoint = https://a:70000",
              "c.conf:1: 'https://a:70000' is not https://HOST or https://HOST:PORT"},
        Wrong{"NoHost", "endpoint = https://:1",
              "c.conf:1: 'https://:1' is not https://HOST or https://HOST:PORT"},
        Wrong{"Ipv6", "endpoint = https://[zz]:1",
              "c.conf:1: 'https://[zz]:1' is not https://HOST or https://HOST:PORT"},
        Wrong{"Relative", "endpoint = https://a\nkey = key.pem",
              "c.conf:2: 'key.pem' is not an absolute path"},
        Wrong{"Twice", "endpoint = https://a\nkey = /a\nkey = /b",
              "c.conf:3: key stands here for the second time"},
        Wrong{"Timeout", "endpoint = https://a\ntimeout = 99",
              "c.conf:2: timeout is 100 to 10000 (ms)"},
        Wrong{"NoValue", "endpoint =", "c.conf:1: endpoint has no value"},
        Wrong{"NoSense", "endpoint https://a", "c.conf:1: a line is NAME = VALUE"},
        Wrong{"Unknown", "endpoints = https://a",
              "c.conf:1: 'endpoints' is none of endpoint, ca, certificate, key and timeout"},
        Wrong{"Several", "a\nb = 1\n",
              "c.conf:1: a line is NAME = VALUE\n"
              "c.conf:2: 'b' is none of endpoint, ca, certificate, key and timeout"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(ClusterSettings, AFileThatIsMissingOrTooLongIsNamed) {
  const test::WorkFolder folder;
  EXPECT_EQ(read_settings(folder / "none", "/k").error().text,
            folder / "none" + ": No such file or directory");
  test::write_file(folder / "long", std::string(100'000, '#'));
  EXPECT_EQ(read_settings(folder / "long", "/k").error().text,
            folder / "long" + ": it is too long");
  test::write_file(folder / "right", "endpoint = https://a\n");
  EXPECT_TRUE(read_settings(folder / "right", "/k").has_value());
}

TEST(ClusterSettings, CertificatesAndKeyThatAreMissingOrSomethingElseAreNamed) {
  const test::WorkFolder folder;
  const Settings settings{.endpoints = {"https://a"},
                          .ca = folder / "ca.pem",
                          .certificate = folder / "cert.pem",
                          .key = folder / "key.pem"};
  const std::string certificate = "-----BEGIN CERTIFICATE-----\nMIIB\n";
  test::write_file(settings.ca, certificate);
  test::write_file(settings.key, certificate);
  const auto checked = check_credentials(settings);
  ASSERT_FALSE(checked.has_value());
  EXPECT_EQ(checked.error().text, settings.certificate + ": No such file or directory\n" +
                                      settings.key + ": it has no private key (PEM)");
  test::write_file(settings.certificate, certificate);
  test::write_file(settings.key, "-----BEGIN EC PRIVATE KEY-----\nMHcC\n");
  EXPECT_TRUE(check_credentials(settings).has_value());
}

TEST(ClusterEndpoints, AllAreTriedAtOnceAndThenAfterPausesThatGrow) {
  StoreMembers endpoints({"a", "b", "c"});
  EXPECT_EQ(endpoints.current(), "a");
  EXPECT_EQ(endpoints.failed(), 0U);
  EXPECT_EQ(endpoints.current(), "b");
  EXPECT_EQ(endpoints.failed(), 0U);
  EXPECT_EQ(endpoints.failed(), 200'000U);
  EXPECT_EQ(endpoints.current(), "a");
  EXPECT_EQ(endpoints.failed() + endpoints.failed(), 0U);
  EXPECT_EQ(endpoints.failed(), 400'000U);
  for (int i = 0; i < 30; ++i) EXPECT_LE(endpoints.failed(), 3'200'000U);
  endpoints.succeeded();
  EXPECT_EQ(endpoints.failed() + endpoints.failed(), 0U);
  EXPECT_EQ(endpoints.failed(), 200'000U);
}

TEST(ClusterEndpoints, AnOnlyOneIsTriedAgainAfterAPause) {
  StoreMembers endpoints({"a"});
  EXPECT_GT(endpoints.failed(), 0U);
  EXPECT_EQ(endpoints.current(), "a");
}

}  // namespace
}  // namespace mlcca::cluster
