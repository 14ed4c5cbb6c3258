// Text from devices and files may hold any bytes; strings in protobuf and MCAP must be UTF-8, or readers refuse the message.
#pragma once

#include <string>
#include <string_view>

namespace roseau::schema {

/// Well-formed as Unicode defines it: no overlong forms, no surrogates, nothing above U+10FFFF.
bool is_utf8(std::string_view text);

/// The text with every ill-formed byte replaced by U+FFFD.
std::string to_utf8(std::string_view text);

}  // namespace roseau::schema
