// A satellite receiver whose fixes come from a recording.
#include "gnss_recording.hpp"

namespace stator::drivers::gnss::recording {

void GnssRecording::step(GnssPorts& ports) {
    if (!ports.fired.received) return;
    ports.position.publish([&] { return device_.fix; });
}

}  // namespace stator::drivers::gnss::recording
