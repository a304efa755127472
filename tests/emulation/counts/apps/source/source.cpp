// Publishes, and counts instructions by a timer that the emulator drives.
#include "source.hpp"

#include <array>

#include "../sink/counter.hpp"

namespace stator {

namespace {

constexpr uint32_t kRuns = 500;

void print(const char* text) {
    register uint32_t r0 asm("r0") = 4;  // semihosting: SYS_WRITE0
    register const char* r1 asm("r1") = text;
    asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

void print(uint32_t value) {
    std::array<char, 11> text{};
    unsigned at = text.size() - 1;
    do {
        text[--at] = static_cast<char>('0' + value % 10);
        value /= 10;
    } while (value != 0);
    print(text.data() + at);
}

void print(const char* name, const Range& range, uint32_t reading) {
    print("COUNT ");
    print(name);
    print(" ");
    print(range.least - reading);
    print(" ");
    print(range.most - reading);
    print("\n");
}

}  // namespace

void Source::step(SourcePorts& ports) {
    if (++runs_ > kRuns) return;
    counter::kControl.write(1);
    const uint32_t value = runs_;
    const uint32_t zero = counter::kCount.read();
    const uint32_t begin = counter::kCount.read();
    ports.awaited.publish([&] {
        return Block{.values = {value, value, value, value, value, value}};
    });
    const uint32_t woken = counter::at_sink;
    const uint32_t quiet = counter::kCount.read();
    ports.quiet.publish([&] {
        return Block{.values = {value, value, value, value, value, value}};
    });
    const uint32_t end = counter::kCount.read();
    reading_.add(begin - zero);
    publish_to_step_.add(woken - begin);
    publish_.add(end - quiet);
    if (runs_ != kRuns) return;
    print("publish_to_step", publish_to_step_, reading_.least);
    print("publish", publish_, reading_.least);
}

}  // namespace stator
