#include "chip/spi.hpp"

#include "chip/chip.hpp"

namespace stator::chip {

namespace {

constexpr uint32_t kControl1 = 0x00, kControl2 = 0x04, kStatus = 0x08, kData = 0x0C;
constexpr uint32_t kMaster = 1U << 2, kEnable = 1U << 6, kSoftwareSelect = 3U << 8;
// Bit order, receive only, 16 bits, CRC, one line.
constexpr uint32_t kNotModelled = 1U << 7 | 1U << 10 | 1U << 11 | 1U << 12 | 1U << 13 | 3U << 14;
constexpr uint32_t kReceiveDma = 1U << 0, kSendDma = 1U << 1, kErrorInterrupt = 1U << 5,
                   kReceivedInterrupt = 1U << 6, kRoomInterrupt = 1U << 7;
constexpr uint32_t kReceived = 1U << 0, kRoom = 1U << 1, kOverrun = 1U << 6, kBusy = 1U << 7;
constexpr Row kRows[] = {
    {kControl1, "CR1", 0, 0xFFFF},      {kControl2, "CR2", 0, 0x00F7},
    {kStatus, "SR", 2, 0x0010, 0x01EF}, {kData, "DR", 0, 0xFFFF},
    {0x10, "CRCPR", 7, 0xFFFF},         {0x1C, "I2SCFGR", 0, 0x0FBF},
    {0x20, "I2SPR", 2, 0x03FF},
};
constexpr DmaClient::Request kSpi1[] = {
    {2, 0, 3, false}, {2, 2, 3, false}, {2, 3, 3, true}, {2, 5, 3, true}};
constexpr DmaClient::Request kSpi2[] = {{1, 3, 0, false}, {1, 4, 0, true}};
constexpr DmaClient::Request kSpi4[] = {
    {2, 0, 4, false}, {2, 3, 5, false}, {2, 1, 4, true}, {2, 4, 5, true}};

}  // namespace

Spi::Spi(Chip& chip, const char* name, uint32_t base, Gate gate, unsigned line)
    : Block(chip, name, base, 0x400, kRows, gate, kHalfWordsAndWords), line_(line) {}

std::span<const DmaClient::Request> Spi::requests() const {
    if (name() == "SPI1") return kSpi1;
    if (name() == "SPI2") return kSpi2;
    return kSpi4;
}

void Spi::attach(SpiPart& part, unsigned select_pin) {
    places_.push_back({&part, select_pin});
    chip_.pins().watch(select_pin, [&part](bool is_high) { part.select(!is_high); });
}

void Spi::reset() {
    Block::reset();
    waiting_.reset();
    shifting_.reset();
    end_ns_ = kNever;
    overrun_was_read_ = false;
}

bool Spi::asks(bool is_to_peripheral) const {
    return is_to_peripheral ? has(kStatus, kRoom) && has(kControl2, kSendDma)
                            : has(kStatus, kReceived) && has(kControl2, kReceiveDma);
}

// A byte that DMA takes away is seen only with the last one of its transfer.
uint64_t Spi::visible_ns() const {
    if (end_ns_ == kNever) return kNever;
    uint32_t left = 0;
    if (has(kControl2, kReceiveDma)) {
        left =
            std::max(chip_.dma(1).items_left(*this, false), chip_.dma(2).items_left(*this, false));
    }
    return end_ns_ + (left > 1 ? left - 1 : 0) * byte_ns();
}

uint32_t Spi::clock_hz() const {
    const Clocks& clocks = chip_.clocks();
    const uint32_t bus_hz = name() == "SPI2" ? clocks.apb1_hz : clocks.apb2_hz;
    return bus_hz >> ((at(kControl1) >> 3 & 7) + 1);
}

uint64_t Spi::byte_ns() const {
    return 8'000'000'000ULL / clock_hz();
}

uint32_t Spi::on_read(uint32_t offset) {
    const uint32_t value = at(offset);
    if (offset == kData) {
        at(kStatus) &= ~kReceived;
        overrun_was_read_ = has(kStatus, kOverrun);
        update();
    } else if (offset == kStatus && overrun_was_read_) {
        at(kStatus) &= ~kOverrun;  // DR, then SR: 28.3.10
        overrun_was_read_ = false;
        update();
    }
    return value;
}

void Spi::on_write(uint32_t offset, uint32_t value) {
    switch (offset) {
        case kControl1:
            control(value);
            break;
        case kData:
            if (!has(kStatus, kRoom)) refuse("DR is written before the last byte has left it");
            if (value > 0xFF) refuse("more than 8 bits are sent");
            waiting_ = static_cast<uint8_t>(value);
            at(kStatus) &= ~kRoom;
            load();
            break;
        case kStatus:
            break;
        default:
            if (offset != kControl2 && value != at(offset))
                refuse(name_of(offset) + " is not modelled");
            at(offset) = value;
    }
    update();
    chip_.serve_dma();
}

void Spi::control(uint32_t value) {
    if ((value & kNotModelled) != 0) refuse("this mode of CR1 is not modelled: " + hex(value));
    if ((at(kControl1) ^ value) != 0 && has(kStatus, kBusy)) {
        refuse("CR1 changes during a transfer (28.5.1)");
    }
    if ((value & kEnable) != 0 &&
        (value & (kMaster | kSoftwareSelect)) != (kMaster | kSoftwareSelect)) {
        refuse("expected a master with its select by software; other modes are not modelled");
    }
    at(kControl1) = value;
    load();
}

void Spi::load() {
    if (!has(kControl1, kEnable) || shifting_ || !waiting_) return;
    shifting_ = waiting_;
    waiting_.reset();
    at(kStatus) |= kRoom | kBusy;
    end_ns_ = chip_.now_ns() + byte_ns();
}

void Spi::run() {
    const uint8_t received = exchange(*shifting_);
    shifting_.reset();
    end_ns_ = kNever;
    if (has(kStatus, kReceived)) {
        at(kStatus) |= kOverrun;
    } else {
        at(kData) = received;
        at(kStatus) |= kReceived;
    }
    load();
    if (!shifting_) at(kStatus) &= ~kBusy;
    update();
    chip_.serve_dma();
}

uint8_t Spi::exchange(uint8_t sent) const {
    const Place* selected = nullptr;
    for (const Place& place : places_) {
        if (chip_.pins().is_high(place.select_pin)) continue;
        if (selected != nullptr) {
            refuse("two parts are selected: " + name_of_pin(selected->select_pin) + " and " +
                   name_of_pin(place.select_pin));
        }
        selected = &place;
    }
    if (selected == nullptr) return 0xFF;  // pulled up
    return selected->part->exchange(sent, clock_hz(), at(kControl1) & 3);
}

void Spi::update() {
    const bool is_raised = (has(kStatus, kReceived) && has(kControl2, kReceivedInterrupt)) ||
                           (has(kStatus, kRoom) && has(kControl2, kRoomInterrupt)) ||
                           (has(kStatus, kOverrun) && has(kControl2, kErrorInterrupt));
    chip_.set_line(line_, is_raised);
}

}  // namespace stator::chip
