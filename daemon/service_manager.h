// Telling systemd how we are (sd_notify). Without systemd every call does nothing.
#pragma once

#include <string>

namespace roseau::daemon {

void notify_ready();
void notify_alive(const std::string& status);  // feeds the watchdog
void notify_stopping();

}  // namespace roseau::daemon
