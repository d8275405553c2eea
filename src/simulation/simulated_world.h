// A rendered world with exact ground truth: what to try the service with when no recording is at
// hand. No data files; the same options always give the same images.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "geometry/camera.h"
#include "geometry/rigid3.h"

namespace eifmap {

struct SimulationOptions {
  // "courtyard"; "block" (four streets round a block of houses); or what mapping finds hard:
  // "tiles" (a room of one tile again and again), "wall" (one plane), "street" (200 m between
  // houses), "corridor" (60 m indoors, every 4.2 m the same again).
  std::string world = "courtyard";
  // In the courtyard and between the tiles. "lap": around, looking ahead and inwards. "turn":
  // straight on, then a turn by 90 degrees in half a second close to things, then straight on, and
  // so forth. "look_around": a lap, at 5 s interrupted for 8 s to turn by 100 degrees on the spot
  // and back. "pause": a lap, interrupted at 5 s to stand still for 20 s.
  // In the block "lap": round it as a car; a lap is 300 images. In the corridor "walk": ahead.
  // Before the wall and in the street. "sideways": to the right, turning a little. In the street
  // "drive": ahead.
  // Everywhere. "standstill": none. "pan": turns by 100 degrees and back once in 8 s, on the spot.
  std::string motion = "lap";
  double speed = 0;      // m/s along the way; 0: of a walk 2.15, in the corridor 1.4, sideways
                         // 0.5, of a drive 4, round the block 5.6
  double roll_deg = 0;   // the camera is slowly rolled so far either way, once in 20 s
  int num_frames = 400;  // a lap and a tenth of the courtyard
  double rate_hz = 20;
  // Radial-tangential distortion as of a cheap lens (k1 -0.28, k2 0.07), else a pinhole.
  bool distorted = false;
  // An equidistant fisheye of 122 by 92 degrees, 152 from corner to corner; else the above.
  bool fisheye = false;
  // "none"; "black": no light; "covered": the right half of the image is; "bus", where the camera
  // looks across the street: one drives past, over a third of the image; "kidnapped": no
  // light, and then the camera is where it is event_to_s on its way, and goes on from there.
  std::string event = "none";
  double event_from_s = 6, event_for_s = 2, event_to_s = 1;
  double noise = 1.5;  // standard deviation of the sensor's noise, gray levels
  int seed = 1;        // of the noise and the surfaces

  std::string problem() const;  // "" or which field is wrong and why
};

class SimulatedWorld {
 public:
  explicit SimulatedWorld(const SimulationOptions& options = {});  // throws std::invalid_argument
  ~SimulatedWorld();
  SimulatedWorld(SimulatedWorld&&) noexcept;
  SimulatedWorld& operator=(SimulatedWorld&&) noexcept;

  int num_frames() const;
  const Camera& camera() const;  // 640x480

  // Of frame i in [0, num_frames()); another i throws std::out_of_range. Frames are independent of
  // each other: any order gives the same images. Thread-safe.
  std::int64_t time_us(int i) const;
  Rigid3 world_from_camera(int i) const;  // x east, y down, z north; m
  cv::Mat render(int i) const;            // CV_8UC1
  cv::Mat depth(int i) const;             // CV_32FC1, m along the optical axis; 0: none

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace eifmap
