// The bus over LCM.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bus/bus.h"

namespace lcm {
class LCM;
class Subscription;
}  // namespace lcm

namespace eifmap {

class LcmBus : public Bus {
 public:
  struct Opened;

  // Joins the network of an LCM URL, or says what is wrong and what to do about it.
  static Opened open(const std::string& url);

  // On an LCM object that others use too, e.g. memq:// for programs that are their own network.
  explicit LcmBus(std::shared_ptr<lcm::LCM> lcm);
  ~LcmBus() override;

  void subscribe(const std::string& pattern, int max_queued, Handler handler) override;
  void unsubscribe_all() override;
  bool publish(const std::string& channel, Bytes bytes) override;
  bool receive(std::chrono::milliseconds timeout) override;

 private:
  std::shared_ptr<lcm::LCM> lcm_;
  std::vector<lcm::Subscription*> subscriptions_;
  std::vector<std::unique_ptr<Handler>> handlers_;
};

struct LcmBus::Opened {
  std::unique_ptr<LcmBus> bus;
  std::string problem;  // "" when there is a bus
  std::string advice;   // "" or what will go wrong, and what to do: a small receive buffer
};

}  // namespace eifmap
