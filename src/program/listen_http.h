// Listens over HTTP with libwebsockets: what its users have in common. A header alone, so that who
// serves nothing need not link it.
#pragma once

#include <libwebsockets.h>

#include <string>

#include "program/listen_at.h"

namespace eifmap {

// `info`: the protocols and what is the caller's own; the rest is filled in. "" and a port, or what
// went wrong. The context, where there is one, is the caller's to destroy, also after a problem.
inline std::string listen_http(const ListenAt& at, lws_context_creation_info info,
                               lws_context*& context, int& port) {
  lws_set_log_level(0, nullptr);
  info.port = at.port;
  info.iface = at.address.c_str();
  info.gid = info.uid = static_cast<decltype(info.uid)>(-1);  // as we are
  info.options = LWS_SERVER_OPTION_HTTP_HEADERS_SECURITY_BEST_PRACTICES_ENFORCE |
                 LWS_SERVER_OPTION_DISABLE_IPV6 | LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND |
                 LWS_SERVER_OPTION_EXPLICIT_VHOSTS;
  context = lws_create_context(&info);
  lws_vhost* const host = context ? lws_create_vhost(context, &info) : nullptr;
  port = host ? lws_get_vhost_listen_port(host) : 0;
  if (port > 0) return "";
  return at.address + ":" + std::to_string(at.port) + " cannot be listened at: choose others by " +
         at.address_option + " and " + at.port_option;
}

}  // namespace eifmap
