// What is compared: the rows of the ablation's tables.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/config.h"

namespace eifmap::test {

struct Row {
  std::string group;  // the table it is in
  std::string name;
  std::string patch = "{}";  // of the configuration, as a user would write it
  int every = 1;             // takes every n-th image
  bool paper = false;        // on top of the preset --paper, else of the defaults
};

// Group by group, in the order of the tables.
std::vector<Row> all_rows();

// Those whose "group: name" holds the text; all for "".
std::vector<Row> rows_with(std::string_view text);

// Throws std::invalid_argument with the row's name when the patch does not fit the configuration.
ServerConfig config_of(const Row& row);

// "every image", "every 5th image"
std::string rate_text(int every);

}  // namespace eifmap::test
