#include "bus/lcm_bus.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <unistd.h>

#include <charconv>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <optional>
#include <stdexcept>

#include "wire/limits.h"

namespace eifmap {
namespace {

constexpr std::string_view kReceiveBufferKey = "recv_buf_size=";

std::optional<long> requested_receive_buffer(const std::string& url) {
  const std::size_t at = url.find(kReceiveBufferKey);
  if (at == std::string::npos) return {};
  const char* begin = url.data() + at + kReceiveBufferKey.size();
  long size = 0;
  if (std::from_chars(begin, url.data() + url.size(), size).ec != std::errc()) return {};
  return size;
}

// The kernel grants no more than net.core.rmem_max, and says nothing.
std::string receive_buffer_advice(const std::string& url) {
  const std::optional<long> wanted = requested_receive_buffer(url);
  long granted = 0;
  if (!wanted || !(std::ifstream("/proc/sys/net/core/rmem_max") >> granted) || granted >= *wanted)
    return "";
  return "the kernel grants a receive buffer of " + std::to_string(granted) + " bytes, not " +
         std::to_string(*wanted) +
         ": large images will be lost. As root: sysctl -w net.core.rmem_max=" +
         std::to_string(*wanted);
}

// liblcm tells standard error, in many lines, what open() tells its caller in one.
class QuietStandardError {
 public:
  QuietStandardError() : kept_(dup(STDERR_FILENO)) {
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (kept_ >= 0 && nowhere >= 0) dup2(nowhere, STDERR_FILENO);
    if (nowhere >= 0) close(nowhere);
  }
  ~QuietStandardError() {
    if (kept_ < 0) return;
    dup2(kept_, STDERR_FILENO);
    close(kept_);
  }
  QuietStandardError(const QuietStandardError&) = delete;
  QuietStandardError& operator=(const QuietStandardError&) = delete;

 private:
  int kept_;
};

constexpr std::string_view kExample = "udpm://239.255.76.67:7667?ttl=0";

// Of GROUP:PORT, each of which may be left out.
std::string multicast_problem(std::string_view address) {
  const std::size_t colon = address.find(':');
  const std::string group(address.substr(0, colon));
  in_addr parsed{};
  if (!group.empty() &&
      (inet_pton(AF_INET, group.c_str(), &parsed) != 1 || !IN_MULTICAST(ntohl(parsed.s_addr))))
    return "its group is " + group + ", wanted a multicast one, 224.0.0.0 to 239.255.255.255";
  if (colon == std::string_view::npos) return "";
  const std::string_view port = address.substr(colon + 1);
  int number = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  if (error != std::errc() || end != port.data() + port.size() || number < 1 || number > 65535)
    return "its port is " + std::string(port) + ", wanted 1 to 65535";
  return "";
}

// What can be seen without a network.
std::string url_problem(const std::string& url) {
  const std::size_t scheme = url.find("://");
  const std::string_view provider = std::string_view(url).substr(0, scheme);
  bool known = false;
  for (const char* name : {"udpm", "mpudpm", "tcpq", "memq", "file"}) known |= provider == name;
  if (scheme == std::string::npos || !known)
    return "it names no kind of network that LCM has; wanted one like " + std::string(kExample);
  if (provider != "udpm") return "";
  const std::string_view rest = std::string_view(url).substr(scheme + 3);
  return multicast_problem(rest.substr(0, rest.find('?')));
}

std::string open_problem(const std::string& url) {
  std::string problem = "LCM cannot be opened at " + url;
  if (url.starts_with("udpm://"))
    return problem +
           ": there is no route for multicast; for this machine alone, as root: ip link set lo "
           "multicast on; ip route add 224.0.0.0/4 dev lo";
  return problem + ": nothing answers there; check the address, or use one like " +
         std::string(kExample);
}

// liblcm passes on whatever sizes a datagram claims, and is C: nothing may be thrown through it.
void dispatch(const lcm::ReceiveBuffer* buffer, const std::string& channel,
              Bus::Handler* handler) noexcept {
  if (buffer->data_size > kMaxMessageBytes) return;
  try {
    (*handler)(channel, {static_cast<const std::uint8_t*>(buffer->data), buffer->data_size});
  } catch (...) {
    // Only memory can run out here: the message is lost, as others are on a network.
  }
}

}  // namespace

LcmBus::Opened LcmBus::open(const std::string& url) {
  Opened opened;
  if (const std::string problem = url_problem(url); !problem.empty()) {
    opened.problem = "LCM cannot be opened at " + url + ": " + problem;
    return opened;
  }
  std::shared_ptr<lcm::LCM> lcm;
  {
    const QuietStandardError quiet;
    lcm = std::make_shared<lcm::LCM>(url);
  }
  // A server of tcpq:// that does not answer leaves an object without a socket.
  if (!lcm->good() || lcm->getFileno() < 0) {
    opened.problem = open_problem(url);
    return opened;
  }
  opened.bus = std::make_unique<LcmBus>(std::move(lcm));
  opened.advice = receive_buffer_advice(url);
  return opened;
}

LcmBus::LcmBus(std::shared_ptr<lcm::LCM> lcm) : lcm_(std::move(lcm)) {
  if (!lcm_ || !lcm_->good()) throw std::invalid_argument("lcm: must be a good LCM object");
}

LcmBus::~LcmBus() {
  unsubscribe_all();
}

void LcmBus::unsubscribe_all() {
  for (lcm::Subscription* subscription : subscriptions_) lcm_->unsubscribe(subscription);
  subscriptions_.clear();
  handlers_.clear();
}

void LcmBus::subscribe(const std::string& pattern, int max_queued, Handler handler) {
  handlers_.push_back(std::make_unique<Handler>(std::move(handler)));
  lcm::Subscription* subscription =
      lcm_->subscribeFunction(pattern, &dispatch, handlers_.back().get());
  subscription->setQueueCapacity(max_queued);
  subscriptions_.push_back(subscription);
}

bool LcmBus::publish(const std::string& channel, Bytes bytes) {
  return lcm_->publish(channel, bytes.data(), static_cast<unsigned>(bytes.size())) == 0;
}

bool LcmBus::receive(std::chrono::milliseconds timeout) {
  return lcm_->handleTimeout(static_cast<int>(timeout.count())) >= 0;
}

}  // namespace eifmap
