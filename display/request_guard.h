// Who may talk to the server: keeps other web sites in the operator's browser away from cameras and controls.
//
// Host   must be an IP address, "localhost" or this machine's own name. A foreign name means that somebody's name server
//        points his site at us (DNS rebinding).
// Origin is sent by browsers only. Actions (POST) take the same origin or loopback; live data (WebSocket) also the hosted
//        viewers listed here, as the Foxglove protocol is made for them.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace roseau::display {

/// `own_name`: this machine's host name; it and `own_name`.local are accepted.
bool host_allowed(std::string_view host, std::string_view own_name);

/// No Origin (not a browser), the same origin as `host`, or any port of the loopback interface.
bool origin_may_act(std::string_view origin, std::string_view host);

/// As above, or a desktop viewer ("file://"), or one of `viewers`.
bool origin_may_watch(std::string_view origin, std::string_view host, std::span<const std::string> viewers);

}  // namespace roseau::display
