// The taps of a build that does not record: nothing of them is left in the image.
#pragma once

#include <cstddef>
#include <cstdint>

namespace stator {

inline constexpr bool kRecords = false;

class Tap {
  public:
    void takes(uint32_t) {}
    void notes(uint32_t) {}
    void builds(void*) {}
    void published(const void*, uint32_t, uint32_t) {}
    uint32_t commits(const void*, uint32_t) { return 0; }
    void committed(uint32_t, uint32_t) {}
};

class Taps {
  public:
    template <class... Parts>
    void connect(Parts&&...) {}
    Tap at(size_t) const { return {}; }
};

}  // namespace stator
