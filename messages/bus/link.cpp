#include "bus/link.h"

#include <charconv>
#include <string_view>

namespace eifmap {
namespace {

// Of the query's `ttl=N`; liblcm's own default is 0.
int time_to_live(std::string_view url) {
  std::size_t at = url.find('?');
  while (at != std::string_view::npos) {
    const std::string_view field = url.substr(at + 1);
    int ttl = 0;
    if (field.starts_with("ttl=") &&
        std::from_chars(field.data() + 4, field.data() + field.size(), ttl).ec == std::errc())
      return ttl;
    at = url.find('&', at + 1);
  }
  return 0;
}

bool is_multicast(std::string_view url) {
  return url.starts_with("udpm://") || url.starts_with("mpudpm://");
}

}  // namespace

Link link_of(const std::string& lcm_url) {
  return is_multicast(lcm_url) && time_to_live(lcm_url) > 0 ? kOffHost : kThisHost;
}

// However liblcm reads it: each ttl that the URL names must be a plain 0.
bool stays_on_this_machine(const std::string& lcm_url) {
  const std::string_view url = lcm_url;
  if (url.starts_with("memq://") || url.starts_with("file://")) return true;
  if (!is_multicast(url)) return false;
  for (std::size_t at = url.find("ttl"); at != std::string_view::npos;
       at = url.find("ttl", at + 1)) {
    const std::string_view value = url.substr(at + 3);
    if (!value.starts_with("=0") || (value.size() > 2 && value[2] != '&')) return false;
  }
  return true;
}

}  // namespace eifmap
