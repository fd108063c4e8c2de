// SPDX-License-Identifier: BSD-2-Clause
#include "cluster/http.hpp"

#include <curl/curl.h>
#include <sys/epoll.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/handle.hpp"
#include "base/loop_timer.hpp"
#include "base/system_error.hpp"
#include "cluster/grpc.hpp"

namespace mlcca::cluster {
namespace {

using Easy = std::unique_ptr<CURL, FreeWith<curl_easy_cleanup>>;
using Multi = std::unique_ptr<CURLM, FreeWith<curl_multi_cleanup>>;
using Headers = std::unique_ptr<curl_slist, FreeWith<curl_slist_free_all>>;

constexpr std::uint64_t kInAMilli = 1000;  // µs
constexpr std::uint64_t kNanosInAMicro = 1000;
/// libcurl ends a call at its limit. This engine ends it so much later if libcurl has not: it keeps
/// no time, for example, for a call that waits for a connection that another call uses.
constexpr std::uint64_t kLate = 20;  // ms

struct Transfer {
  Request request;
  std::string body;
  std::size_t sent = 0;
  std::size_t answers = 0;  ///< answers that were handed on, of a call with one answer
  grpc::FrameReader frames{kLongestAnswer};
  grpc::Trailers trailers;
  std::array<char, CURL_ERROR_SIZE> words{};
  CURLcode result = CURLE_OK;
  std::uint64_t ends_at = 0;  ///< CLOCK_MONOTONIC ns at which it ends at the latest; 0: never
  bool stuck = false;         ///< libcurl has not ended it in its time
  bool done = false;
  bool dropped = false;
  Easy easy;
};

End end_of(const Transfer& transfer) {
  End end;
  end.sent = transfer.sent != 0;
  end.stuck = transfer.stuck;
  end.too_long = transfer.frames.too_long();
  if (end.too_long)
    end.text = "an answer is too long";
  else if (!transfer.trailers.problem().empty())
    end.text = transfer.trailers.problem();
  else if (transfer.stuck)
    end.text = "there was no answer in time";
  else if (transfer.result != CURLE_OK)
    end.text =
        transfer.words[0] != '\0' ? transfer.words.data() : curl_easy_strerror(transfer.result);
  else if (transfer.answers > 1)
    end.text = "it answers more than once";
  else if (!transfer.trailers.status())
    end.text = "the call ended without a status";
  else if (*transfer.trailers.status() == grpc::kOk && transfer.answers == 0 &&
           !transfer.request.stays_open)
    end.text = "the call ended without an answer";
  else if (*transfer.trailers.status() == grpc::kOk && !transfer.frames.at_end())
    end.text = "an answer is not whole";
  else {
    end.status = *transfer.trailers.status();
    end.text = transfer.trailers.message();
  }
  return end;
}

std::size_t on_body(char* octets, std::size_t size, std::size_t count, void* transfer) noexcept {
  const std::size_t n = size * count;
  return static_cast<Transfer*>(transfer)->frames.push({octets, n}) ? n : 0;
}

std::size_t on_header(char* line, std::size_t size, std::size_t count, void* transfer) noexcept {
  const std::size_t n = size * count;
  return static_cast<Transfer*>(transfer)->trailers.take({line, n}) ? n : 0;
}

/// There is deliberately no function that seeks to the beginning of the body: so curl cannot repeat
/// a request when a reused connection ends while it waits for the answer.
std::size_t on_send(char* to, std::size_t size, std::size_t count, void* of) noexcept {
  auto& transfer = *static_cast<Transfer*>(of);
  const std::size_t n = std::min(size * count, transfer.body.size() - transfer.sent);
  transfer.body.copy(to, n, transfer.sent);
  transfer.sent += n;
  if (n == 0 && transfer.request.stays_open) return CURL_READFUNC_PAUSE;
  return n;
}

template <class Value>
bool set(CURL* easy, CURLoption option, Value value) {
  return curl_easy_setopt(easy, option, value) == CURLE_OK;  // NOLINT(*-vararg)
}

/// Runs the sockets and the timer of libcurl in the event loop. The channel and its calls share it.
class Engine : public std::enable_shared_from_this<Engine> {
 public:
  Engine(sd_event* loop, Settings settings, std::string endpoint)
      : loop_(loop), settings_(std::move(settings)), endpoint_(std::move(endpoint)) {}
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;
  Engine(Engine&&) = delete;
  Engine& operator=(Engine&&) = delete;
  ~Engine() {
    multi_.reset();  // this calls on_socket() for the sockets that are no longer watched
  }

  Result<void> begin() {
    multi_.reset(curl_multi_init());
    for (const char* line : {"Content-Type: application/grpc", "TE: trailers", "hasleader: true",
                             "User-Agent: mlcca-cluster", "Expect:", "Accept:"})
      if (curl_slist* longer = curl_slist_append(headers_.get(), line); longer != nullptr) {
        (void)headers_.release();
        headers_.reset(longer);
      }
    if (!multi_ || !headers_) return fail("libcurl has no memory");
    // NOLINTBEGIN(*-vararg)
    curl_multi_setopt(multi_.get(), CURLMOPT_SOCKETFUNCTION, on_socket);
    curl_multi_setopt(multi_.get(), CURLMOPT_SOCKETDATA, this);
    curl_multi_setopt(multi_.get(), CURLMOPT_TIMERFUNCTION, on_timer);
    curl_multi_setopt(multi_.get(), CURLMOPT_TIMERDATA, this);
    curl_multi_setopt(multi_.get(), CURLMOPT_PIPELINING, long{CURLPIPE_MULTIPLEX});
    curl_multi_setopt(multi_.get(), CURLMOPT_MAX_TOTAL_CONNECTIONS, 1L);
    // NOLINTEND(*-vararg)
    if (auto added = add_timer(timer_, on_time); !added) return added;
    return add_timer(late_, on_late);
  }

  /// Starts a transfer; nullptr without memory.
  std::shared_ptr<Transfer> start(Request request) {
    auto transfer = std::make_shared<Transfer>();
    transfer->body = grpc::framed(request.message);
    transfer->request = std::move(request);
    transfer->easy.reset(curl_easy_init());
    if (!transfer->easy || !prepare(*transfer) ||
        curl_multi_add_handle(multi_.get(), transfer->easy.get()) != CURLM_OK)
      return nullptr;
    if (const std::uint64_t limit = transfer->request.timeout_ms; limit != 0)
      transfer->ends_at = monotonic_ns() + ((limit + kLate) * kInAMilli * kNanosInAMicro);
    transfers_.push_back(transfer);
    plan();
    return transfer;
  }

  void drop(Transfer& transfer) {
    transfer.dropped = true;
    if (!transfer.done) curl_multi_remove_handle(multi_.get(), transfer.easy.get());
    transfer.easy.reset();
    std::erase_if(transfers_, [&transfer](const auto& one) { return one.get() == &transfer; });
  }

  void end_soon(const std::shared_ptr<Transfer>& transfer) {
    transfers_.push_back(transfer);
    arm(0);
  }

 private:
  bool prepare(Transfer& transfer) {
    CURL* easy = transfer.easy.get();

    const std::string url = endpoint_ + std::string(transfer.request.method);
    const auto timeout = static_cast<long>(settings_.timeout_ms);
    return set(easy, CURLOPT_URL, url.c_str()) && set(easy, CURLOPT_PROTOCOLS_STR, "https") &&
           set(easy, CURLOPT_HTTP_VERSION, long{CURL_HTTP_VERSION_2TLS}) &&
           set(easy, CURLOPT_PIPEWAIT, 1L) && set(easy, CURLOPT_PROXY, "") &&
           set(easy, CURLOPT_NOSIGNAL, 1L) && set(easy, CURLOPT_TCP_KEEPALIVE, 1L) &&
           // The end of a call does not wait for the thread that looks up a name.
           set(easy, CURLOPT_QUICK_EXIT, 1L) &&
           set(easy, CURLOPT_SSLVERSION, long{CURL_SSLVERSION_TLSv1_2}) &&
           set(easy, CURLOPT_CAINFO, settings_.ca.c_str()) &&
           // The authorities of the system are not trusted.
           set(easy, CURLOPT_CAPATH, static_cast<char*>(nullptr)) &&
           set(easy, CURLOPT_SSLCERT, settings_.certificate.c_str()) &&
           set(easy, CURLOPT_SSLKEY, settings_.key.c_str()) &&
           // A key with a passphrase is refused; otherwise curl would ask for it on the terminal.
           set(easy, CURLOPT_KEYPASSWD, "") && set(easy, CURLOPT_CONNECTTIMEOUT_MS, timeout) &&
           set(easy, CURLOPT_TIMEOUT_MS, static_cast<long>(transfer.request.timeout_ms)) &&
           set(easy, CURLOPT_HTTPHEADER, headers_.get()) && set(easy, CURLOPT_POST, 1L) &&
           // The last octets of a request and its end are sent together: a server that answers
           // before the end arrives closes the stream, and curl 7.88 then gives up the connection.
           set(easy, CURLOPT_POSTFIELDSIZE_LARGE,
               transfer.request.stays_open ? curl_off_t{-1}
                                           : static_cast<curl_off_t>(transfer.body.size())) &&
           set(easy, CURLOPT_READFUNCTION, on_send) && set(easy, CURLOPT_READDATA, &transfer) &&
           set(easy, CURLOPT_WRITEFUNCTION, on_body) && set(easy, CURLOPT_WRITEDATA, &transfer) &&
           set(easy, CURLOPT_HEADERFUNCTION, on_header) &&
           set(easy, CURLOPT_HEADERDATA, &transfer) &&
           set(easy, CURLOPT_ERRORBUFFER, transfer.words.data()) &&
           set(easy, CURLOPT_PRIVATE, &transfer);
  }

  /// Adds a timer that is off.
  Result<void> add_timer(EventSource& to, sd_event_time_handler_t call) {
    sd_event_source* raw = nullptr;
    const int e = sd_event_add_time_relative(loop_, &raw, CLOCK_MONOTONIC, 0, 1, call, this);
    if (e < 0) return system_error("timer", -e);
    to.reset(raw);
    sd_event_source_set_enabled(raw, SD_EVENT_OFF);
    return {};
  }

  static int on_socket(CURL*, curl_socket_t fd, int what, void* self, void*) noexcept {
    static_cast<Engine*>(self)->watch(fd, what);
    return 0;
  }
  static int on_timer(CURLM*, long ms, void* self) noexcept {
    static_cast<Engine*>(self)->arm(ms);
    return 0;
  }
  static int on_io(sd_event_source*, int fd, std::uint32_t events, void* self) noexcept {
    int what = 0;
    if ((events & EPOLLIN) != 0) what |= CURL_CSELECT_IN;
    if ((events & EPOLLOUT) != 0) what |= CURL_CSELECT_OUT;
    if ((events & ~(EPOLLIN | EPOLLOUT)) != 0) what |= CURL_CSELECT_ERR;
    static_cast<Engine*>(self)->act(fd, what);
    return 0;
  }
  static int on_time(sd_event_source*, std::uint64_t, void* self) noexcept {
    static_cast<Engine*>(self)->act(CURL_SOCKET_TIMEOUT, 0);
    return 0;
  }
  static int on_late(sd_event_source*, std::uint64_t, void* self) noexcept {
    static_cast<Engine*>(self)->end_late();
    return 0;
  }

  void watch(curl_socket_t fd, int what) {
    if (what == CURL_POLL_REMOVE) {
      sockets_.erase(fd);
      return;
    }
    std::uint32_t events = 0;
    if (what != CURL_POLL_OUT) events |= EPOLLIN;
    if (what != CURL_POLL_IN) events |= EPOLLOUT;
    auto& source = sockets_[fd];
    if (source) {
      sd_event_source_set_io_events(source.get(), events);
      return;
    }
    sd_event_source* raw = nullptr;
    if (sd_event_add_io(loop_, &raw, fd, events, on_io, this) >= 0) source.reset(raw);
  }

  void arm(long ms) {
    if (ms < 0) {
      sd_event_source_set_enabled(timer_.get(), SD_EVENT_OFF);
      return;
    }
    sd_event_source_set_time_relative(timer_.get(), static_cast<std::uint64_t>(ms) * kInAMilli);
    sd_event_source_set_enabled(timer_.get(), SD_EVENT_ONESHOT);
  }

  void act(curl_socket_t fd, int what) {
    const auto kept = shared_from_this();
    int running = 0;
    curl_multi_socket_action(multi_.get(), fd, what, &running);
    int left = 0;
    while (const CURLMsg* message = curl_multi_info_read(multi_.get(), &left)) {
      CURL* easy = message->easy_handle;
      const CURLcode result = message->data.result;
      char* found = nullptr;
      curl_easy_getinfo(easy, CURLINFO_PRIVATE, &found);  // NOLINT(*-vararg)
      auto& transfer =
          *reinterpret_cast<Transfer*>(found);  // NOLINT(*-reinterpret-cast): of libcurl
      transfer.result = result;
      transfer.done = true;
      curl_multi_remove_handle(multi_.get(), easy);
    }
    deliver();
  }

  /// Wakes up when the first call must have ended.
  void plan() {
    std::uint64_t next = 0;
    for (const auto& one : transfers_)
      if (!one->done && one->ends_at != 0 && (next == 0 || one->ends_at < next))
        next = one->ends_at;
    const std::uint64_t now = monotonic_ns();
    if (next == 0) return;
    sd_event_source_set_time_relative(late_.get(),
                                      next > now ? ((next - now) / kNanosInAMicro) + 1 : 0);
    sd_event_source_set_enabled(late_.get(), SD_EVENT_ONESHOT);
  }

  /// Ends the calls that libcurl has not ended in their time.
  void end_late() {
    const auto kept = shared_from_this();
    act(CURL_SOCKET_TIMEOUT, 0);
    const std::uint64_t now = monotonic_ns();
    for (const auto& one : transfers_) {
      if (one->done || one->ends_at == 0 || one->ends_at > now) continue;
      one->done = one->stuck = true;
      one->result = CURLE_OPERATION_TIMEDOUT;
      curl_multi_remove_handle(multi_.get(), one->easy.get());
    }
    deliver();
    plan();
  }

  /// Hands received answers to the calls that still exist.
  void deliver() {
    const auto all = transfers_;
    for (const auto& transfer : all) deliver(*transfer);
    std::erase_if(transfers_, [](const auto& one) { return one->request.on_end == nullptr; });
  }
  void deliver(Transfer& transfer) {
    while (!transfer.dropped) {
      auto answer = transfer.frames.next();
      if (!answer) break;
      if (!transfer.request.stays_open && ++transfer.answers > 1) {
        refuse(transfer);
        break;
      }
      if (transfer.request.on_answer) transfer.request.on_answer(std::move(*answer));
    }
    if (transfer.dropped || !transfer.done) return;
    if (const auto on_end = std::exchange(transfer.request.on_end, nullptr))
      on_end(end_of(transfer));
  }
  /// Ends a transfer whose server sends more answers than one: it could go on without end.
  void refuse(Transfer& transfer) {
    if (!std::exchange(transfer.done, true))
      curl_multi_remove_handle(multi_.get(), transfer.easy.get());
  }

  sd_event* loop_;
  Settings settings_;
  std::string endpoint_;
  Headers headers_;
  std::map<curl_socket_t, EventSource> sockets_;
  EventSource timer_;
  EventSource late_;  ///< rings when a call must have ended
  std::vector<std::shared_ptr<Transfer>> transfers_;
  Multi multi_;
};

class HttpCall final : public Call {
 public:
  HttpCall(std::shared_ptr<Engine> engine, std::shared_ptr<Transfer> transfer)
      : engine_(std::move(engine)), transfer_(std::move(transfer)) {}
  HttpCall(const HttpCall&) = delete;
  HttpCall& operator=(const HttpCall&) = delete;
  HttpCall(HttpCall&&) = delete;
  HttpCall& operator=(HttpCall&&) = delete;
  ~HttpCall() override { engine_->drop(*transfer_); }

  [[nodiscard]] bool sent() const override { return transfer_->sent != 0; }

 private:
  std::shared_ptr<Engine> engine_;
  std::shared_ptr<Transfer> transfer_;
};

class HttpChannel final : public Channel {
 public:
  explicit HttpChannel(std::shared_ptr<Engine> engine) : engine_(std::move(engine)) {}

  std::unique_ptr<Call> start(Request request) override {
    Request kept{.method = {}, .message = {}, .on_answer = {}, .on_end = request.on_end};
    auto transfer = engine_->start(std::move(request));
    if (!transfer) {
      transfer = std::make_shared<Transfer>();
      transfer->request = std::move(kept);
      transfer->result = CURLE_OUT_OF_MEMORY;
      transfer->done = true;
      engine_->end_soon(transfer);
    }
    return std::make_unique<HttpCall>(engine_, std::move(transfer));
  }

 private:
  std::shared_ptr<Engine> engine_;
};

}  // namespace

Result<void> prepare_http() {
  const CURLcode e = curl_global_init(CURL_GLOBAL_ALL);
  if (e != CURLE_OK) return fail(std::string("libcurl: ") + curl_easy_strerror(e));
  const auto* const version = curl_version_info(CURLVERSION_NOW);
  if ((version->features & CURL_VERSION_HTTP2) == 0) return fail("libcurl is without HTTP/2");
  return {};
}

Result<std::unique_ptr<Channel>> open_http(sd_event* loop, const Settings& settings,
                                           const std::string& endpoint) {
  auto engine = std::make_shared<Engine>(loop, settings, endpoint);
  if (auto begun = engine->begin(); !begun) return std::unexpected(begun.error());
  return std::make_unique<HttpChannel>(std::move(engine));
}

}  // namespace mlcca::cluster
