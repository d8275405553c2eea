#include "bus/lcm_bus.h"

#include <charconv>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <optional>
#include <stdexcept>

#include "convert/limits.h"

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

std::string open_problem(const std::string& url) {
  std::string problem = "LCM cannot be opened at " + url;
  if (url.starts_with("udpm://"))
    problem +=
        "\nIs there a route for multicast? For this machine alone, as root:"
        "\n  ip link set lo multicast on"
        "\n  ip route add 224.0.0.0/4 dev lo";
  return problem;
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
  auto lcm = std::make_shared<lcm::LCM>(url);
  Opened opened;
  if (!lcm->good()) {
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
