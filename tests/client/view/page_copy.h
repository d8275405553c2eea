// What a page keeps, as web/src/map_copy.js does it: for comparing one page with another.
#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

namespace eifmap::test {

class PageCopy {
 public:
  using Json = nlohmann::json;

  void apply(const std::string& text) {
    Json message = Json::parse(text);
    if (message.contains("snapshot")) sections = Json::object();
    if (message.contains("snapshot") || message.contains("clear")) {
      path = Json::array();
      keyframes = landmarks = Json::object();
    }
    if (message.contains("path")) take_path(message["path"]);
    take(message, "keyframes", 8, keyframes);
    take(message, "landmarks", 7, landmarks);
    for (const char* of_all : {"snapshot", "clear", "path"}) message.erase(of_all);
    sections.update(message);
  }

  // By id, as text.
  Json keyframes = Json::object(), landmarks = Json::object();
  Json path = Json::array();
  Json sections = Json::object();

  bool operator==(const PageCopy&) const = default;

 private:
  void take_path(const Json& part) {
    const auto from = part["from"].get<std::size_t>();
    ASSERT_LE(from, path.size()) << "a hole in the path";
    path.erase(path.begin() + static_cast<long>(from), path.end());
    const Json& steps = part["steps"];
    for (std::size_t i = 0; i < steps.size(); i += 4)
      path.push_back({steps[i], steps[i + 1], steps[i + 2], steps[i + 3]});
  }

  static void take(Json& message, const std::string& section, std::size_t size, Json& to) {
    for (const auto& id : message.value("removed_" + section, Json::array())) to.erase(id.dump());
    const Json list = message.value(section, Json::array());
    ASSERT_EQ(list.size() % size, 0u);
    for (std::size_t i = 0; i < list.size(); i += size)
      to[list[i].dump()] =
          Json(list.begin() + static_cast<long>(i + 1), list.begin() + static_cast<long>(i + size));
    message.erase(section);
    message.erase("removed_" + section);
  }
};

}  // namespace eifmap::test
