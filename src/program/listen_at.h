// Where something is served over HTTP, and who may read it.
#pragma once

#include <string>
#include <string_view>

namespace eifmap {

inline constexpr int kDefaultViewPort = 8090;

struct ListenAt {
  std::string address = "127.0.0.1";  // IPv4, of this machine
  int port = kDefaultViewPort;        // 0: any free one
  // What a user calls the two, in problems.
  const char* address_option = "--address";
  const char* port_option = "--port";

  bool loopback() const { return address.starts_with("127."); }
};

// "" when it is an IPv4 address and a port, else which is not.
std::string form_problem(const ListenAt& at);

// "" when that can be listened at now, else what is wrong, which value, and what to do.
std::string listen_problem(const ListenAt& at);

// Whether a browser's page of `origin` ("" for a program that is none) may have the map: only the
// one that came from here. On loopback `host` must be this machine by name or number too, or
// another site's name, made to mean 127.0.0.1, would do.
bool may_look(std::string_view host, std::string_view origin, bool loopback);

}  // namespace eifmap
