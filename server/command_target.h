// What commands do: the seam between their desk and what is commanded.
#pragma once

#include <cstdint>
#include <eifmap/reply_t.hpp>
#include <string>
#include <utility>
#include <vector>

#include "reason.h"

namespace eifmap {

// What becomes the reply.
struct CommandOutcome {
  std::int8_t result = reply_t::RESULT_OK;  // RESULT_*
  Reason reason = Reason::kNone;            // why not
  std::string message;                      // what was done; with a reason, its details
  std::vector<std::pair<std::string, std::string>> values = {};

  static CommandOutcome refuse(Reason reason, std::string detail,
                               std::int8_t result = reply_t::RESULT_ERROR) {
    return {result, reason, std::move(detail)};
  }
};

// A camera's mapping, or a server as a whole. Each is called between two frames; what it throws
// becomes a reply of an internal error. Doing what is done already is no error: it is said.
class CommandTarget {
 public:
  CommandTarget() = default;
  virtual ~CommandTarget() = default;
  CommandTarget(const CommandTarget&) = delete;
  CommandTarget& operator=(const CommandTarget&) = delete;

  // The map in use, as published; 0 none.
  struct Place {
    std::int64_t map_id = 0, map_epoch = 0, map_seq = 0;
  };
  virtual Place place() const = 0;

  virtual CommandOutcome ping() = 0;
  virtual CommandOutcome pause() = 0;
  virtual CommandOutcome resume() = 0;
  virtual CommandOutcome reset() = 0;
  virtual CommandOutcome maps() = 0;
  virtual CommandOutcome snapshot() = 0;
  // `sigma`: relative, above 0.
  virtual CommandOutcome set_scale(double metres_per_unit, double sigma) = 0;
  virtual CommandOutcome shutdown() = 0;

  // What needs maps that are stored. `name`: of the user's choice, "" where none is given.
  virtual CommandOutcome save(const std::string& name);
  virtual CommandOutcome load(const std::string& name);
  virtual CommandOutcome checkpoint();
  virtual CommandOutcome undo();
  virtual CommandOutcome localize_only(bool on);
};

}  // namespace eifmap
