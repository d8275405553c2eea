// What server and client need of a network: named channels of bytes.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "wire/bytes.h"

namespace eifmap {

class Bus {
 public:
  // Called in the thread that calls receive(). `bytes` are gone when it returns.
  using Handler = std::function<void(const std::string& channel, Bytes bytes)>;

  Bus() = default;
  virtual ~Bus() = default;
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  // `pattern`: a regular expression for whole channel names. `max_queued`: messages that the bus
  // itself may hold while the handler is busy; what comes then is lost. Not while receive() runs.
  virtual void subscribe(const std::string& pattern, int max_queued, Handler handler) = 0;

  // Of this bus's own subscriptions; handlers are not called any more. Not while receive() runs.
  virtual void unsubscribe_all() = 0;

  // From any thread. False when it could not be sent.
  virtual bool publish(const std::string& channel, Bytes bytes) = 0;

  // Waits at most this long for messages and hands them out. False when the bus is broken.
  virtual bool receive(std::chrono::milliseconds timeout) = 0;
};

}  // namespace eifmap
