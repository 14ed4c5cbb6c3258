#include "daemon/commands.h"
namespace roseau::daemon {
int import_command(const ImportArguments&) { return kExitFailed; }
}  // namespace roseau::daemon
