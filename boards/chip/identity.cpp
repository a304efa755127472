#include "chip/identity.hpp"

namespace stator::chip {

namespace {

constexpr Row kSystem[] = {
    {0x210, "UID0", 0x00290041, 0, 0xFFFFFFFF},
    {0x214, "UID1", 0x33365110, 0, 0xFFFFFFFF},
    {0x218, "UID2", 0x35363032, 0, 0xFFFFFFFF},
    {0x220, "FLASHSIZE", 2048U << 16, 0, 0xFFFFFFFF},
};
constexpr Row kDebug[] = {
    {0x00, "IDCODE", 0x20036419, 0, 0xFFFFFFFF},
    {0x04, "CR", 0, 0x000000E7},
    {0x08, "APB1FZ", 0, 0x06E01DFF},
    {0x0C, "APB2FZ", 0, 0x00070003},
};

}  // namespace

DeviceId::DeviceId(Chip& chip)
    : Block(chip, "system memory", 0x1FFF7800, 0x400, kSystem, {}, kAllWidths) {}

Debug::Debug(Chip& chip) : Block(chip, "DBGMCU", 0xE0042000, 0x400, kDebug, {}, kWords) {}

}  // namespace stator::chip
