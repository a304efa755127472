#include "chip/exti.hpp"

#include "chip/chip.hpp"

namespace stator::chip {

namespace {

constexpr Row kConfigurationRows[] = {
    {0x00, "MEMRMP", 0, 0x00000D07},
    {0x04, "PMC", 0, 0x00870000},
    {0x08, "EXTICR", 0, 0xFFFF, 0, 4},
    {0x20, "CMPCR", 0, 0x00000001, 0x00000100},
};

constexpr uint32_t kMask = 0x00, kRising = 0x08, kFalling = 0x0C, kSoftware = 0x10, kPending = 0x14;
constexpr uint32_t kLines = 0x007FFFFF;
constexpr Row kRows[] = {
    {kMask, "IMR", 0, kLines},     {0x04, "EMR", 0, kLines},        {kRising, "RTSR", 0, kLines},
    {kFalling, "FTSR", 0, kLines}, {kSoftware, "SWIER", 0, kLines}, {kPending, "PR", 0, kLines},
};

}  // namespace

SystemConfiguration::SystemConfiguration(Chip& chip)
    : Block(chip, "SYSCFG", 0x40013800, 0x400, kConfigurationRows, {0x44, 14}, kAllWidths) {}

unsigned SystemConfiguration::port_of(unsigned line) const {
    return at(0x08 + 4 * (line / 4)) >> 4 * (line % 4) & 0xF;
}

Exti::Exti(Chip& chip, const SystemConfiguration& configuration)
    : Block(chip, "EXTI", 0x40013C00, 0x400, kRows, {}, kWords), configuration_(configuration) {}

void Exti::edge(unsigned pin, bool is_rising) {
    const unsigned line = pin % 16;
    if (configuration_.port_of(line) != pin / 16) return;
    if (!has(is_rising ? kRising : kFalling, 1U << line)) return;
    // A line that is masked is not noted either: 12.2.5 has the mask before the pending register.
    at(kPending) |= 1U << line & at(kMask);
    update();
}

void Exti::on_write(uint32_t offset, uint32_t value) {
    if (offset == kPending) {
        at(kPending) &= ~value;
        at(kSoftware) &= ~value;
    } else if (offset == kSoftware) {
        at(kPending) |= value & ~at(kSoftware) & at(kMask);
        at(kSoftware) |= value;
    } else {
        at(offset) = value;
    }
    update();
}

void Exti::update() {
    const uint32_t raised = at(kPending) & at(kMask);
    for (unsigned line = 0; line < 5; ++line) chip_.set_line(6 + line, (raised >> line & 1) != 0);
    chip_.set_line(23, (raised & 0x03E0) != 0);
    chip_.set_line(40, (raised & 0xFC00) != 0);
}

}  // namespace stator::chip
