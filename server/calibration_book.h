// Calibrations of the cameras that are heard: which one is in use, and which one waits for the
// first frame that belongs to it.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "geometry/camera.h"
#include "server/taken.h"
#include "wire/bytes.h"
#include "wire/channel.h"

namespace eifmap {

class CalibrationBook {
 public:
  // `given`: by the configuration, for every camera; then no other is taken. `hfov_deg`: > 0 where
  // one is to be guessed that nobody tells.
  CalibrationBook(const std::optional<Camera>& given, double hfov_deg)
      : given_(given), hfov_deg_(hfov_deg) {}

  // The one in use; null none. It stays where it is until withdraw_guess(), and is another one's
  // value after take() and change().
  const Camera* of(const std::string& camera) const;

  // A calibration message of this camera. `is_mapped`: its frames go into a map; then another
  // calibration than the one in use waits. kNone: taken, or known already. Else refused, and
  // nothing has changed.
  Taken take(const std::string& camera, Bytes bytes, bool is_mapped);

  // Where there is none and one may be guessed: from the size of this frame. Whether it has been;
  // withdraw_guess() where the frame was bad, whose size says nothing.
  bool guess(const Channel& channel, Bytes bytes);
  void withdraw_guess(const std::string& camera);
  bool is_guessed(const std::string& camera) const { return guessed_.contains(camera); }

  // Of a frame that names this id (0: of a publisher that does not say) and has this size, px: the
  // one in use, or the waiting one when the frame can only belong to that: it names its id or,
  // naming none, has the size of only that one. Throws std::out_of_range where none is in use.
  const Camera& of_frame(const std::string& camera, std::int64_t id, int width, int height) const;
  // Throws std::out_of_range where none waits.
  const Camera& waiting(const std::string& camera) const { return waiting_.at(camera); }
  // The waiting one is in use from now on, and the other one waits, unless it was a guess.
  void change(const std::string& camera);

 private:
  const std::optional<Camera> given_;
  const double hfov_deg_;
  std::map<std::string, Camera> in_use_;   // by camera, from messages
  std::map<std::string, Camera> waiting_;  // the last one heard that is not in use
  std::set<std::string> guessed_;          // cameras whose calibration in use is a guess
};

}  // namespace eifmap
