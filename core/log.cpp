#include "core/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>

#include <mutex>

namespace roseau {

std::shared_ptr<spdlog::logger> log(const std::string& name) {
  static std::mutex mutex;
  const std::scoped_lock lock(mutex);
  if (auto logger = spdlog::get(name)) return logger;
  auto logger = spdlog::stderr_color_mt(name);
  logger->set_pattern("%Y-%m-%dT%H:%M:%S.%e %^%l%$ %n: %v");
  return logger;
}

}  // namespace roseau
