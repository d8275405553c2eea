// Every reader of files that somebody else may have written.
#include "fuzz/target.h"
#include "messages/samples.h"
#include "sequence/camera_file.h"
#include "sequence/camera_yaml.h"
#include "sequence/decisions_file.h"
#include "sequence/measurements_file.h"
#include "sequence/tum.h"

namespace eifmap::fuzz {
namespace {

// `read`: of a file, gives something with a problem; `check`: what must hold of it where there is
// none.
template <class File>
Target reader(const std::string& name, File (*read)(const std::filesystem::path&),
              std::function<void(const File&)> check, const std::vector<std::string>& seeds) {
  return {name,
          [read, check](Bytes bytes) {
            const MemoryFile memory(bytes);
            const File file = read(memory.path());
            if (file.problem.empty()) check(file);
            return file.problem.empty();
          },
          [seeds] {
            std::vector<Wire> wires;
            for (const std::string& seed : seeds) wires.push_back(wire_of(seed));
            return wires;
          }};
}

void check_camera(const Camera& camera) {
  require(camera.problem().empty(), "a camera that is read is one");
}

const char* const kRosYaml = R"(image_width: 640
image_height: 480
camera_name: cam
camera_matrix:
  rows: 3
  cols: 3
  data: [525.0, 0.0, 319.5, 0.0, 525.0, 239.5, 0.0, 0.0, 1.0]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.1, -0.2, 0.001, 0.002, 0.0]
)";
const char* const kOpenCvYaml = R"(%YAML:1.0
---
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 5.25e+02, 0., 3.195e+02, 0., 5.25e+02, 2.395e+02, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ 1e-01, -2e-01, 1e-03, 2e-03, 0. ]
)";
const char* const kSensorYaml = R"(sensor_type: camera
T_BS:
  cols: 4
  rows: 4
  data: [0.0, -1.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.2, 0.0, 0.0, 1.0, 0.3, 0.0, 0.0, 0.0, 1.0]
resolution: [752, 480]
camera_model: pinhole
intrinsics: [458.654, 457.296, 367.215, 248.375]
distortion_model: radial-tangential
distortion_coefficients: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]
)";

std::string measurement_lines() {
  std::string lines;
  for (const NamedMeasurement& sample : samples::measurements()) {
    AbsoluteMeasurement m = sample.measurement;
    m.id.seq += static_cast<std::int64_t>(lines.size());  // each has a name of its own
    lines += line_of(m) + "\n";
  }
  return lines;
}

// What is written of it is read back.
void check_measurements(const MeasurementsFile& file) {
  std::string lines;
  for (const AbsoluteMeasurement& m : file.measurements) {
    require(check_measurement(m) == Reason::kNone, "a measurement that is read is one");
    lines += line_of(m) + "\n";
  }
  const MemoryFile memory(wire_of(lines));
  require(read_measurements(memory.path()).measurements.size() == file.measurements.size(),
          "what is written is read");
}

void check_decisions(const DecisionsFile& file) {
  std::string lines;
  for (const Decision& decision : file.decisions) lines += line_of(decision) + "\n";
  const MemoryFile memory(wire_of(lines));
  require(read_decisions(memory.path()).decisions == file.decisions, "what is written is read");
}

}  // namespace

std::vector<Target> file_targets() {
  return {
      reader<CameraFile>(
          "calib_json", &read_camera, [](const CameraFile& file) { check_camera(file.camera); },
          {R"({"width": 640, "height": 480, "fx": 525, "fy": 525, "cx": 319.5, "cy": 239.5,
 "model": "fisheye", "distortion": [0.01, 0, 0, 0]})"}),
      reader<CameraFile>("camera_yaml", &read_camera_yaml,
                         [](const CameraFile& file) { check_camera(file.camera); },
                         {kRosYaml, kOpenCvYaml}),
      reader<SensorFile>("sensor_yaml", &read_sensor,
                         [](const SensorFile& file) { check_camera(file.camera); }, {kSensorYaml}),
      reader<MeasurementsFile>("measurements", &read_measurements, &check_measurements,
                               {measurement_lines()}),
      reader<DecisionsFile>("decisions", &read_decisions, &check_decisions,
                            {line_of(samples::published_decision().decision) + "\n"}),
      reader<TumTrajectory>(
          "tum", &read_tum, [](const TumTrajectory&) {},
          {"# time x y z qx qy qz qw\n1.5 1 2 3 0 0 0 1\n2.5,1,2,3,0,0.6,0,0.8\n"}),
  };
}

}  // namespace eifmap::fuzz
