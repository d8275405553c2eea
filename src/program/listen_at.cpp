#include "program/listen_at.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace eifmap {
namespace {

std::string bind_problem(const ListenAt& at, int error) {
  const std::string port = std::to_string(at.port), port_option = at.port_option,
                    address_option = at.address_option;
  switch (error) {
    case 0:
      return "";
    case EADDRINUSE:
      return "port " + port + " of " + at.address +
             " is taken: end the program that has it, or choose another with " + port_option;
    case EADDRNOTAVAIL:
      return address_option + " is " + at.address +
             ", which is no address of this machine: use 127.0.0.1 or one that `ip address` shows";
    case EACCES:
      return "port " + port + " is for root alone: choose one from 1024 with " + port_option;
    default:
      return at.address + ":" + port + " cannot be listened at (" + std::strerror(error) +
             "): choose others with " + address_option + " and " + port_option;
  }
}

}  // namespace

std::string form_problem(const ListenAt& at) {
  in_addr address;
  if (inet_pton(AF_INET, at.address.c_str(), &address) != 1)
    return std::string(at.address_option) + " is '" + at.address +
           "', wanted an IPv4 address of this machine, such as 127.0.0.1";
  if (at.port < 0 || at.port > 65535)
    return std::string(at.port_option) + " is " + std::to_string(at.port) + ", wanted 0 to 65535";
  return "";
}

std::string listen_problem(const ListenAt& at) {
  if (std::string problem = form_problem(at); !problem.empty()) return problem;
  sockaddr_in where{};
  where.sin_family = AF_INET;
  inet_pton(AF_INET, at.address.c_str(), &where.sin_addr);
  where.sin_port = htons(static_cast<std::uint16_t>(at.port));
  const int probe = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return bind_problem(at, errno);
  // As the real one: not in the way of connections that are just closing.
  const int on = 1;
  setsockopt(probe, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  const bool bound = bind(probe, reinterpret_cast<const sockaddr*>(&where), sizeof(where)) == 0;
  const int error = bound ? 0 : errno;
  close(probe);
  return bind_problem(at, error);
}

bool may_look(std::string_view host, std::string_view origin, bool loopback) {
  if (!origin.empty() && origin != "http://" + std::string(host)) return false;
  if (!loopback) return true;
  const std::string name(host.substr(0, host.rfind(':')));
  in_addr number;
  return name == "localhost" || inet_pton(AF_INET, name.c_str(), &number) == 1;
}

}  // namespace eifmap
