// Something to command that remembers what it was told.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "server/command_target.h"

namespace eifmap::test {

class FakeTarget : public CommandTarget {
 public:
  Place place() const override { return {2, 1, 7}; }
  CommandOutcome ping() override { return done("ping"); }
  CommandOutcome pause() override { return done("pause"); }
  CommandOutcome resume() override { return done("resume"); }
  CommandOutcome reset() override { return done("reset"); }
  CommandOutcome maps() override { throw std::runtime_error("no maps here"); }
  CommandOutcome snapshot() override { return CommandOutcome::refuse(Reason::kNoMap, ""); }
  CommandOutcome set_scale(double metres_per_unit, double sigma) override {
    return done("scale " + std::to_string(metres_per_unit) + " " + std::to_string(sigma));
  }
  CommandOutcome shutdown() override { return done("shutdown"); }

  std::vector<std::string> told;

 private:
  CommandOutcome done(const std::string& what) {
    told.push_back(what);
    return {reply_t::RESULT_OK,
            Reason::kNone,
            what + " is done",
            {{"times", std::to_string(told.size())}}};
  }
};

}  // namespace eifmap::test
