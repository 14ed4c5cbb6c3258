// write_session PATH: a session through the real recorder, for readers that are not ours: one sample of every kind with every
// field set, then a second of pictures and wind.
#include <cstdio>

#include "recorder/recorder.h"
#include "tests/support/samples.h"

using namespace roseau;

namespace {

constexpr std::uint32_t kPictures = 30;
constexpr std::uint32_t kWinds = 200;
constexpr std::int64_t kBegin_ns = 200'000'000'000'000;

void record_second(recorder::Recorder& recorder, StreamTable& streams, FramePool& pool) {
  const StreamId camera = streams.add({.topic = "/camera1/image", .kind = "frame", .device = "camera1"});
  const StreamId sonic = streams.add({.topic = "/sonic/wind", .kind = "wind", .role = StreamRole::derived, .device = "sonic"});
  for (std::uint32_t i = 0; i < kWinds; ++i) {
    const HostTime time = host_time_from_ns(kBegin_ns + std::int64_t{i} * 5'000'000);
    const SampleHeader header{.stream = sonic, .sequence = i, .arrival_time = time, .sample_time = time};
    recorder.record({header, WindSample{.u_mps = 0.5 * i, .v_mps = -1, .valid = true}}, time);
    if (i * kPictures / kWinds == (i + 1) * kPictures / kWinds) continue;
    const HostTime exposed = time + Duration{1};
    const SampleHeader picture{.stream = camera, .sequence = i, .arrival_time = exposed, .sample_time = exposed};
    recorder.record({picture, testing::filled_frame(pool, 640, 480, 640)}, exposed);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_session PATH\n");
    return 2;
  }
  StreamTable streams;
  FramePool pool(40, std::size_t{640} * 480);
  recorder::Recorder recorder(streams);
  const recorder::SessionDescription description{"0.0.0-test", "[run]\n", "[site]\n", Duration{7}, {{"operator", "J. Müller"}}};
  if (auto opened = recorder.open(argv[1], description); !opened) {
    std::fprintf(stderr, "%s\n", opened.error().message.c_str());
    return 1;
  }
  for (std::size_t i = 0; i < kSampleKindCount; ++i) {
    recorder.record(testing::filled_sample(static_cast<SampleKind>(i), streams, pool),
                    host_time_from_ns(kBegin_ns - 1'000'000'000 + static_cast<std::int64_t>(i)));
  }
  record_second(recorder, streams, pool);
  const auto closed = recorder.close();
  if (!closed) std::fprintf(stderr, "%s\n", closed.error().message.c_str());
  return closed ? 0 : 1;
}
