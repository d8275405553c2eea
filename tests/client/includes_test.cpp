// What the client is made of: followed through every header, it never reaches the filter, the map
// or the server; and the program carries none of their code.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

const fs::path kSource = EIFMAP_SOURCE_DIR;

// The project's file that an include means, or nothing for those of others.
fs::path resolve(const std::string& include) {
  for (const char* root : {"src", "messages", "client/library", "."})
    if (const fs::path file = kSource / root / include; fs::is_regular_file(file)) return file;
  return {};
}

// Follows quoted includes; for a header also its .cpp, since that is what gets linked.
void follow(const fs::path& file, std::set<std::string>& seen) {
  if (!seen.insert(fs::relative(file, kSource).string()).second) return;
  static const std::regex kInclude(R"re(^\s*#include\s+"([^"]+)")re");
  std::ifstream in(file);
  std::smatch match;
  for (std::string line; std::getline(in, line);)
    if (std::regex_search(line, match, kInclude))
      if (const fs::path next = resolve(match[1]); !next.empty()) follow(next, seen);
  fs::path code = file;
  code.replace_extension(".cpp");
  if (file.extension() == ".h" && fs::exists(code)) follow(code, seen);
}

TEST(Includes, TheClientReachesNeitherFilterNorMapNorServer) {
  std::set<std::string> seen;
  for (const char* folder : {"client", "client/view"})
    for (const auto& entry : fs::directory_iterator(kSource / folder))
      if (const auto kind = entry.path().extension(); kind == ".cpp" || kind == ".h")
        follow(entry.path(), seen);
  EXPECT_GT(seen.size(), 40u);  // the search works
  EXPECT_TRUE(seen.contains("src/features/surf.cpp"));
  EXPECT_TRUE(seen.contains("client/view/page_server.cpp"));
  for (const std::string& file : seen)
    for (const char* forbidden :
         {"src/filter/", "src/map/", "src/mapper.", "src/storage/", "server/"})
      EXPECT_FALSE(file.starts_with(forbidden)) << file;
}

// Of the core it knows the reasons' codes alone.
TEST(Includes, TheClientsLibraryStandsByItself) {
  std::set<std::string> seen;
  follow(kSource / "client/library/map_client.cpp", seen);
  EXPECT_TRUE(seen.contains("messages/published/map_follower.cpp"));
  for (const std::string& file : seen)
    EXPECT_TRUE(file.starts_with("client/library/") || file.starts_with("messages/published/") ||
                file.starts_with("messages/wire/") || file.starts_with("src/reason."))
        << file;
}

TEST(Includes, TheProgramHasNoFilterInIt) {
  const std::string command = "nm -C " EIFMAP_BINARY " 2>/dev/null";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  ASSERT_TRUE(pipe);
  int ours = 0;
  std::array<char, 65536> line;
  while (fgets(line.data(), static_cast<int>(line.size()), pipe.get())) {
    const std::string symbol = line.data();
    if (symbol.find("eifmap::") == std::string::npos) continue;
    ++ours;
    for (const char* forbidden : {"eifmap::Mapper::", "InformationFilter", "MappingServer"})
      EXPECT_EQ(symbol.find(forbidden), std::string::npos) << symbol;
  }
  if (ours == 0) GTEST_SKIP() << "skipped: no nm, or a stripped program";
}

}  // namespace
