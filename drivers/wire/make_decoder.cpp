#include "drivers/wire/make_decoder.h"

#include "drivers/wire/anemometer.h"
#include "drivers/wire/led_board.h"
#include "drivers/wire/magnetic_tracker.h"
#include "drivers/wire/nmea0183.h"
#include "drivers/wire/trisonica.h"

namespace roseau::wire {

std::unique_ptr<Decoder> make_decoder(const StreamInfo& raw, StreamTable& streams) {
  if (auto decoder = make_anemometer_decoder(raw, streams)) return decoder;
  if (auto decoder = make_trisonica_decoder(raw, streams)) return decoder;
  if (auto decoder = make_nmea_decoder(raw, streams)) return decoder;
  if (auto decoder = make_magnetic_tracker_decoder(raw, streams)) return decoder;
  return make_led_board_decoder(raw, streams);
}

}  // namespace roseau::wire
