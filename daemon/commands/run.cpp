#include <cstdio>
#include <utility>

#include "daemon/commands.h"
#include "daemon/commands/failure.h"
#include "daemon/session.h"
#include "daemon/sources.h"

namespace roseau::daemon {

int run_command(const RunArguments& arguments) {
  auto config = load_config(arguments.config);
  if (!config) return failed(config.error());
  auto sources = make_sources(*config);
  if (!sources) return failed(sources.error());
  SessionPlan plan;
  plan.mode = config->simulation ? "demo" : "live";
  plan.config = std::move(*config);
  plan.sources = std::move(sources->sources);
  plan.cameras = std::move(sources->cameras);
  plan.image_storage = std::move(sources->image_storage);
  plan.first_actions = std::move(sources->first_actions);
  plan.arguments = arguments.session;
  return run_session(std::move(plan));
}

}  // namespace roseau::daemon
