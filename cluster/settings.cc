// SPDX-License-Identifier: BSD-2-Clause
#include "cluster/settings.hpp"

#include <fcntl.h>

#include <algorithm>
#include <array>
#include <optional>
#include <set>

#include "base/handle.hpp"
#include "base/number.hpp"
#include "base/system_error.hpp"

namespace mlcca::cluster {
namespace {

constexpr std::size_t kMostEndpoints = 16;
constexpr std::size_t kLongestFile = std::size_t{64} << 10U;         // bytes
constexpr std::size_t kLongestCertificates = std::size_t{1} << 20U;  // bytes
constexpr std::uint64_t kShortest = 100;                             // ms
constexpr std::uint64_t kLongest = 10'000;
constexpr std::string_view kScheme = "https://";
constexpr std::string_view kDefaultPort = "2379";
constexpr std::string_view kSpace = " \t\r";

std::string_view stripped(std::string_view text) {
  const auto first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

bool is_of_host(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '-';
}
bool is_of_ipv6(char c) {
  return (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F') || (c >= '0' && c <= '9') || c == ':';
}

/// The length of the host name or address at the front of `text`; 0 if there is none.
std::size_t host_size(std::string_view text) {
  if (text.starts_with('[')) {
    const auto end = text.find(']');
    const bool right = end != std::string_view::npos && end > 1 &&
                       std::ranges::all_of(text.substr(1, end - 1), is_of_ipv6);
    return right ? end + 1 : 0;
  }
  return static_cast<std::size_t>(std::ranges::find_if_not(text, is_of_host) - text.begin());
}

Result<std::string> endpoint_in(std::string_view text) {
  if (text.starts_with("http://"))
    return fail("the store is reached by TLS alone: https:// and a client certificate");
  const auto wrong = [text] {
    return fail("'" + std::string(text) + "' is not https://HOST or https://HOST:PORT");
  };
  if (!text.starts_with(kScheme)) return wrong();
  const std::string_view place = text.substr(kScheme.size());
  const std::size_t host = host_size(place);
  if (host == 0) return wrong();
  std::string_view port = place.substr(host);
  if (port.empty()) return std::string(text) + ':' + std::string(kDefaultPort);
  if (!port.starts_with(':')) return wrong();
  port.remove_prefix(1);
  if (const auto number = number_in<std::uint16_t>(port); !number || *number == 0) return wrong();
  return std::string(text);
}

class Parser {
 public:
  Parser(std::string file, const std::string& credentials) : file_(std::move(file)) {
    settings_.ca = credentials + "/ca.pem";
    settings_.certificate = credentials + "/cert.pem";
    settings_.key = credentials + "/key.pem";
  }

  void take(std::string_view line) {
    ++line_;
    line = stripped(line.substr(0, line.find('#')));
    if (line.empty()) return;
    const auto equals = line.find('=');
    if (equals == std::string_view::npos) {
      wrong("a line is NAME = VALUE");
      return;
    }
    const std::string name(stripped(line.substr(0, equals)));
    const std::string_view value = stripped(line.substr(equals + 1));
    if (value.empty())
      wrong(name + " has no value");
    else if (name != "endpoint" && !seen_.insert(name).second)
      wrong(name + " stands here for the second time");
    else
      set(name, value);
  }

  Result<Settings> end() {
    if (settings_.endpoints.empty() && errors_.empty()) {
      line_ = 0;
      wrong("no endpoint is stated");
    }
    if (!errors_.empty()) return fail(errors_);
    return settings_;
  }

 private:
  void set(const std::string& name, std::string_view value) {
    if (name == "endpoint")
      add_endpoint(value);
    else if (name == "ca")
      set_file(settings_.ca, value);
    else if (name == "certificate")
      set_file(settings_.certificate, value);
    else if (name == "key")
      set_file(settings_.key, value);
    else if (name == "timeout")
      set_timeout(value);
    else
      wrong("'" + name + "' is none of endpoint, ca, certificate, key and timeout");
  }
  void add_endpoint(std::string_view value) {
    auto endpoint = endpoint_in(value);
    if (!endpoint)
      wrong(endpoint.error().text);
    else if (settings_.endpoints.size() == kMostEndpoints)
      wrong("there are more than " + std::to_string(kMostEndpoints) + " endpoints");
    else
      settings_.endpoints.push_back(std::move(*endpoint));
  }
  void set_file(std::string& to, std::string_view value) {
    if (value.starts_with('/'))
      to = value;
    else
      wrong("'" + std::string(value) + "' is not an absolute path");
  }
  void set_timeout(std::string_view value) {
    const auto number = number_in<std::uint64_t>(value);
    if (number && *number >= kShortest && *number <= kLongest)
      settings_.timeout_ms = *number;
    else
      wrong("timeout is " + std::to_string(kShortest) + " to " + std::to_string(kLongest) +
            " (ms)");
  }
  void wrong(const std::string& words) {
    if (!errors_.empty()) errors_ += '\n';
    errors_ += file_ + ':' + (line_ == 0 ? "" : std::to_string(line_) + ':') + ' ' + words;
  }

  std::string file_;
  Settings settings_;
  std::set<std::string> seen_;
  std::string errors_;
  unsigned line_ = 0;
};

/// The content of a file of at most `most` bytes.
Result<std::string> read_short_file(const std::string& file, std::size_t most) {
  // A pipe without a writer must not make it wait.
  const Fd from(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));  // NOLINT(*-vararg)
  if (!from) return system_error(file);
  std::string text(most + 1, '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const ssize_t n = ::read(from.get(), text.data() + size, text.size() - size);
    if (n < 0) return system_error(file);
    if (n == 0) break;
    size += static_cast<std::size_t>(n);
  }
  if (size > most) return fail(file + ": it is too long");
  text.resize(size);
  return text;
}

}  // namespace

Result<Settings> parse_settings(std::string_view text, const std::string& file,
                                const std::string& credentials) {
  Parser parser(file, credentials);
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    parser.take(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return parser.end();
}

Result<Settings> read_settings(const std::string& file, const std::string& credentials) {
  const auto text = read_short_file(file, kLongestFile);
  if (!text) return std::unexpected(text.error());
  return parse_settings(*text, file, credentials);
}

Result<void> check_credentials(const Settings& settings) {
  struct Credential {
    const std::string& file;
    std::string_view marks;  ///< a line of PEM
    const char* content;
  };
  std::string errors;
  for (const Credential& one :
       {Credential{settings.ca, "-----BEGIN CERTIFICATE-----", "certificate"},
        Credential{settings.certificate, "-----BEGIN CERTIFICATE-----", "certificate"},
        Credential{settings.key, "PRIVATE KEY-----", "private key"}}) {
    const auto text = read_short_file(one.file, kLongestCertificates);
    if (text && text->contains(one.marks)) continue;
    if (!errors.empty()) errors += '\n';
    errors += text ? one.file + ": it has no " + one.content + " (PEM)" : text.error().text;
  }
  return errors.empty() ? Result<void>() : fail(std::move(errors));
}

}  // namespace mlcca::cluster
