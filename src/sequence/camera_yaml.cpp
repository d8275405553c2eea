#include "sequence/camera_yaml.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>

#include "sequence/file_text.h"

namespace eifmap {
namespace fs = std::filesystem;
namespace {

// Within this file problems travel as YAML's own exceptions, which know their line.
[[noreturn]] void fail(const YAML::Node& node, const std::string& problem) {
  throw YAML::RepresentationException(node.Mark(), problem);
}

// The first of the names that is there: every writer has its own.
YAML::Node find(const YAML::Node& root, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (const YAML::Node found = root[name]) return found;
  throw YAML::RepresentationException(YAML::Mark::null_mark(),
                                      std::string("'") + *names.begin() + "' is missing");
}

double number(const YAML::Node& node) {
  double value = 0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value))
    fail(node,
         "'" + (node.IsScalar() ? node.Scalar() : std::string("a list")) + "' is no finite number");
  return value;
}

// A list, or a matrix with its list under `data`.
std::vector<double> numbers(const YAML::Node& node) {
  const YAML::Node list = node.IsMap() && node["data"] ? node["data"] : node;
  if (!list.IsSequence()) fail(list, "is no list of numbers");
  std::vector<double> values;
  for (const YAML::Node& entry : list) values.push_back(number(entry));
  return values;
}

std::vector<double> exactly(const YAML::Node& node, std::size_t count, const char* wanted) {
  std::vector<double> values = numbers(node);
  if (values.size() != count)
    fail(node, "has " + std::to_string(values.size()) + " numbers; wanted " + wanted);
  return values;
}

int size_of(const YAML::Node& node) {
  const double value = number(node);
  if (!(value >= 1 && value <= 65536 && value == std::floor(value)))
    fail(node, "'" + node.Scalar() + "' is no size; wanted a whole number of pixels");
  return static_cast<int>(value);
}

void set_lens(Camera& camera, const std::string& model, const YAML::Node& coefficients) {
  std::vector<double> values = numbers(coefficients);
  while (!values.empty() && values.back() == 0) values.pop_back();
  const bool fisheye = model == "equidistant" || model == "fisheye";
  if (values.size() > (fisheye ? 4u : 5u))
    fail(coefficients,
         "has " + std::to_string(values.size()) +
             " coefficients; wanted at most k1 k2 p1 p2 k3, of a fisheye k1 k2 k3 k4");
  std::copy(values.begin(), values.end(), camera.distortion.begin());
  if (fisheye)
    camera.model = CameraModel::kFisheye;
  else if (!values.empty())
    camera.model = CameraModel::kRadialTangential;
}

// "" when none is named.
std::string lens_model(const YAML::Node& root) {
  const YAML::Node node = root["distortion_model"];
  if (!node) return "";
  const std::string model = node.IsScalar() ? node.Scalar() : "a list";
  for (const char* known : {"", "plumb_bob", "rational_polynomial", "radial-tangential", "radtan",
                            "equidistant", "fisheye"})
    if (model == known) return model;
  fail(node,
       "distortion_model is '" + model + "'; wanted plumb_bob, radial-tangential or equidistant");
}

void check(const Camera& camera) {
  if (const std::string problem = camera.problem(); !problem.empty())
    throw YAML::RepresentationException(YAML::Mark::null_mark(), problem);
}

Camera camera_info(const YAML::Node& root) {
  Camera camera;
  camera.width = size_of(find(root, {"image_width", "width"}));
  camera.height = size_of(find(root, {"image_height", "height"}));
  const auto k = exactly(find(root, {"camera_matrix", "Camera_Matrix", "K", "k"}), 9,
                         "9: the camera matrix row by row");
  camera.fx = k[0];
  camera.fy = k[4];
  camera.cx = k[2];
  camera.cy = k[5];
  set_lens(camera, lens_model(root),
           find(root, {"distortion_coefficients", "Distortion_Coefficients", "D", "d"}));
  check(camera);
  return camera;
}

Rigid3 rigid(const YAML::Node& node) {
  const auto t = exactly(node, 16, "16: a 4x4 transform row by row");
  Eigen::Matrix3d rotation;
  rotation << t[0], t[1], t[2], t[4], t[5], t[6], t[8], t[9], t[10];
  const double skewed = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (!(skewed < 1e-3) || rotation.determinant() < 0)
    fail(node, "T_BS is no rigid transform; its rotation's rows must be orthonormal");
  return {Eigen::Quaterniond(rotation).normalized(), {t[3], t[7], t[11]}};
}

SensorFile sensor(const YAML::Node& root) {
  SensorFile result;
  Camera& camera = result.camera;
  const YAML::Node resolution = find(root, {"resolution"});
  exactly(resolution, 2, "2: width and height");
  camera.width = size_of(resolution[0]);
  camera.height = size_of(resolution[1]);
  const auto k = exactly(find(root, {"intrinsics"}), 4, "4: fx fy cx cy");
  camera.fx = k[0];
  camera.fy = k[1];
  camera.cx = k[2];
  camera.cy = k[3];
  set_lens(camera, lens_model(root), find(root, {"distortion_coefficients"}));
  check(camera);
  result.body_from_camera = rigid(find(root, {"T_BS"}));
  return result;
}

// What `read` makes of the file; its exceptions as a sentence.
template <class Result>
Result read_yaml(const fs::path& file, Result (*read)(const YAML::Node&)) {
  Result result;
  std::string text = file_text(file).value_or("");
  if (text.empty()) {
    result.problem = file.string() + ": cannot be read, or is empty";
    return result;
  }
  // OpenCV's "%YAML:1.0" is none of YAML's directives; a comment keeps the lines' numbers.
  if (text[0] == '%') text[0] = '#';
  try {
    const YAML::Node root = YAML::Load(text);
    if (!root.IsMap()) fail(root, "holds no keys; wanted a calibration as YAML");
    return read(root);
  } catch (const YAML::Exception& error) {
    result.problem = file.string();
    if (!error.mark.is_null()) result.problem += " line " + std::to_string(error.mark.line + 1);
    result.problem += ": " + error.msg;
  }
  return result;
}

}  // namespace

CameraFile read_camera_yaml(const fs::path& file) {
  return read_yaml<CameraFile>(file, [](const YAML::Node& root) -> CameraFile {
    return {camera_info(root), ""};
  });
}

SensorFile read_sensor(const fs::path& file) {
  return read_yaml<SensorFile>(file, &sensor);
}

}  // namespace eifmap
