// The end of the way that is counted.
#include "sink.hpp"

#include "counter.hpp"

namespace stator {

void Sink::step(SinkPorts& /*ports*/) {
    counter::at_sink = counter::kCount.read();
}

}  // namespace stator
