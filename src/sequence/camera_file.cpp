#include "sequence/camera_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sequence/camera_yaml.h"
#include "sequence/file_text.h"

namespace eifmap {
namespace fs = std::filesystem;
namespace {

// Takes json[key] as a finite number; the first problem stays in `problem`.
double number_at(const nlohmann::json& json, const char* key, std::string& problem) {
  if (!problem.empty()) return 0;
  const auto found = json.find(key);
  if (found == json.end() || !found->is_number()) {
    problem = std::string("'") + key + "' is missing or no number; wanted pixels";
    return 0;
  }
  return found->get<double>();
}

int size_at(const nlohmann::json& json, const char* key, std::string& problem) {
  const double value = number_at(json, key, problem);
  if (problem.empty() && !(value >= 1 && value <= 65536 && value == std::floor(value)))
    problem =
        std::string("'") + key + "' is " + json[key].dump() + "; wanted a whole number of pixels";
  return problem.empty() ? static_cast<int>(value) : 0;
}

void read_distortion(const nlohmann::json& json, Camera& camera, std::string& problem) {
  const auto found = json.find("distortion");
  if (!problem.empty() || found == json.end()) return;
  const bool numbers = found->is_array() && found->size() <= camera.distortion.size() &&
                       std::all_of(found->begin(), found->end(),
                                   [](const nlohmann::json& k) { return k.is_number(); });
  if (!numbers) {
    problem = "'distortion' is " + found->dump() +
              "; wanted up to 5 numbers: k1 k2 p1 p2 k3, of a fisheye k1 k2 k3 k4";
    return;
  }
  for (std::size_t i = 0; i < found->size(); ++i) camera.distortion[i] = (*found)[i].get<double>();
}

// Without a name, coefficients make a radial-tangential lens.
void read_model(const nlohmann::json& json, Camera& camera, std::string& problem) {
  if (!problem.empty()) return;
  const bool bent = std::any_of(camera.distortion.begin(), camera.distortion.end(),
                                [](double k) { return k != 0; });
  if (bent) camera.model = CameraModel::kRadialTangential;
  const auto found = json.find("model");
  if (found == json.end() || *found == "radial_tangential") return;
  if (*found == "fisheye")
    camera.model = CameraModel::kFisheye;
  else if (*found != "pinhole")
    problem = "'model' is " + found->dump() + "; wanted pinhole, radial_tangential or fisheye";
  else if (bent)
    problem = "'model' is pinhole, but 'distortion' is not zero; leave one of them out";
}

CameraFile read_camera_json(const fs::path& file) {
  CameraFile result;
  const std::optional<std::string> read = file_text(file);
  if (!read) return {{}, file.string() + ": cannot be read"};
  const std::string& text = *read;
  nlohmann::json json;
  try {
    json = nlohmann::json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    const auto line =
        1 + std::count(text.begin(), text.begin() + std::min(error.byte, text.size()), '\n');
    return {{},
            file.string() + " line " + std::to_string(line) +
                ": is no JSON from here on; look for a missing quote, comma or bracket"};
  } catch (const nlohmann::json::out_of_range&) {
    return {{}, file.string() + ": has a number that is too large"};
  }
  if (!json.is_object())
    return {{}, file.string() + ": is no JSON object; wanted {\"width\": ..., \"height\": ...}"};
  Camera& camera = result.camera;
  camera.width = size_at(json, "width", result.problem);
  camera.height = size_at(json, "height", result.problem);
  camera.fx = number_at(json, "fx", result.problem);
  camera.fy = number_at(json, "fy", result.problem);
  camera.cx = number_at(json, "cx", result.problem);
  camera.cy = number_at(json, "cy", result.problem);
  read_distortion(json, camera, result.problem);
  read_model(json, camera, result.problem);
  if (result.problem.empty()) result.problem = camera.problem();
  if (!result.problem.empty()) result.problem = file.string() + ": " + result.problem;
  return result;
}

}  // namespace

CameraFile read_camera(const fs::path& file) {
  const bool yaml = file.extension() == ".yaml" || file.extension() == ".yml";
  return yaml ? read_camera_yaml(file) : read_camera_json(file);
}

}  // namespace eifmap
