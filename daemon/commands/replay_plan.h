#pragma once

#include "core/result.h"
#include "daemon/commands.h"
#include "daemon/session.h"

namespace roseau::daemon {

/// What `replay` runs, and `estimate` too.
Result<SessionPlan> make_replay_plan(const ReplayArguments& arguments);

}  // namespace roseau::daemon
