// Civil time (UTC) as text. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace roseau::recorder {

/// "2026-11-22T15:46:08.250Z" with `digits` (0 to 9) behind the point, cut off, not rounded: times keep their order, and a
/// stamp never names a second that has not begun. `separator` stands between date and time; `zone` at the end.
std::string utc_text(std::int64_t utc_ns, int digits, char separator = 'T', std::string_view zone = "Z");

/// ISO 8601: 2026-11-22T15:46:08.25Z, with a blank for the T, without the Z, without seconds, or with +02:00 for the Z.
/// Nanoseconds since 1970; nothing when it is no such time.
std::optional<std::int64_t> parse_utc(std::string_view text);

}  // namespace roseau::recorder
