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

}  // namespace

Link link_of(const std::string& lcm_url) {
  const bool multicast = lcm_url.starts_with("udpm://") || lcm_url.starts_with("mpudpm://");
  return multicast && time_to_live(lcm_url) > 0 ? kOffHost : kThisHost;
}

}  // namespace eifmap
