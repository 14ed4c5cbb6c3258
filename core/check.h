// CHECK: a broken invariant is a bug in roseau, never bad input. It says where and aborts.
#pragma once

#include <cstdio>
#include <cstdlib>

namespace roseau {

[[noreturn]] inline void check_failed(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: CHECK failed: %s (a bug in roseau: please report it)\n", file, line, condition);
  std::abort();
}

}  // namespace roseau

// A macro because the condition's text and place are the message.
#define ROSEAU_CHECK(condition) \
  (static_cast<bool>(condition) ? void(0) : ::roseau::check_failed(#condition, __FILE__, __LINE__))
