// The board's side of virtual time: a list of events.
#include "events.hpp"

namespace stator {

namespace testing {
std::multimap<uint64_t, std::function<void()>> events;
}

namespace board {

uint64_t next_event_us() {
    return testing::events.empty() ? kNever : testing::events.begin()->first;
}

void advance(uint64_t now_us) {
    while (!testing::events.empty() && testing::events.begin()->first <= now_us) {
        const auto happen = testing::events.extract(testing::events.begin());
        happen.mapped()();
    }
}

}  // namespace board

}  // namespace stator
