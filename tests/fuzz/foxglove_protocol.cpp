// What a client of the live protocol sends, as text and as bytes: always understood or answered with words, never more. What is
// understood of playback control says the same when it is written out again.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "display/foxglove_protocol.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roseau::display;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  if (const auto text = parse_client_text(bytes); !text) {
    if (text.error().message.empty()) std::abort();
    status_message(StatusLevel::error, text.error().message);
  }
  const auto control = parse_client_binary(bytes);
  if (!control) {
    if (control.error().message.empty()) std::abort();
    return 0;
  }
  if (!(control->speed > 0) || !std::isfinite(control->speed)) std::abort();
  if (control->request_id.size() > kMostRequestIdBytes) std::abort();
  // The request's id stands at the end of what it needs: 19 bytes, then the id.
  if (bytes.substr(19, control->request_id.size()) != control->request_id) std::abort();
  playback_state_message({.speed = control->speed, .request_id = control->request_id});
  return 0;
}
