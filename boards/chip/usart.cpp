#include "chip/usart.hpp"

#include <array>

#include "chip/chip.hpp"

namespace stator::chip {

namespace {

constexpr uint32_t kStatus = 0x00, kData = 0x04, kRate = 0x08, kControl1 = 0x0C, kControl2 = 0x10,
                   kControl3 = 0x14;
constexpr uint32_t kOverrun = 1U << 3, kIdle = 1U << 4, kReceived = 1U << 5, kComplete = 1U << 6,
                   kRoom = 1U << 7;
constexpr uint32_t kReceives = 1U << 2, kSends = 1U << 3, kEnable = 1U << 13, kEightfold = 1U << 15;
constexpr uint32_t kReceiveDma = 1U << 6, kSendDma = 1U << 7, kErrorInterrupt = 1U << 0;
constexpr Row kRows[] = {
    {kStatus, "SR", 0xC0, 0x0360, 0x009F},
    {kData, "DR", 0, 0x01FF},
    {kRate, "BRR", 0, 0xFFFF},
    {kControl1, "CR1", 0, 0xBFFF},
    {kControl2, "CR2", 0, 0x7F6F},
    {kControl3, "CR3", 0, 0x0FFF},
    {0x18, "GTPR", 0, 0xFFFF},
};
constexpr unsigned kBitsOfByte = 10;  // with start and stop

struct Requests {
    const char* name;
    std::array<DmaClient::Request, 4> requests;
};
// Tables 42 and 43. Where there are less than four, one is repeated.
constexpr Requests kRequests[] = {
    {"USART1", {{{2, 2, 4, false}, {2, 5, 4, false}, {2, 7, 4, true}, {2, 7, 4, true}}}},
    {"USART2", {{{1, 5, 4, false}, {1, 7, 6, false}, {1, 6, 4, true}, {1, 6, 4, true}}}},
    {"USART3", {{{1, 1, 4, false}, {1, 1, 4, false}, {1, 3, 4, true}, {1, 4, 7, true}}}},
    {"UART4", {{{1, 2, 4, false}, {1, 2, 4, false}, {1, 4, 4, true}, {1, 4, 4, true}}}},
    {"USART6", {{{2, 1, 5, false}, {2, 2, 5, false}, {2, 6, 5, true}, {2, 7, 5, true}}}},
    {"UART7", {{{1, 3, 5, false}, {1, 3, 5, false}, {1, 1, 5, true}, {1, 1, 5, true}}}},
    {"UART8", {{{1, 6, 5, false}, {1, 6, 5, false}, {1, 0, 5, true}, {1, 0, 5, true}}}},
};

}  // namespace

Usart::Usart(Chip& chip, const char* name, uint32_t base, Gate gate, unsigned line)
    : Block(chip, name, base, 0x400, kRows, gate, kHalfWordsAndWords), line_(line) {}

std::span<const DmaClient::Request> Usart::requests() const {
    for (const Requests& row : kRequests) {
        if (row.name == name()) return row.requests;
    }
    return {};
}

void Usart::reset() {
    Block::reset();
    waiting_.reset();
    shifting_.reset();
    sent_ns_ = received_ns_ = kNever;
    seen_ = 0;
}

bool Usart::asks(bool is_to_peripheral) const {
    return is_to_peripheral ? has(kStatus, kRoom) && has(kControl3, kSendDma)
                            : has(kStatus, kReceived) && has(kControl3, kReceiveDma);
}

uint64_t Usart::byte_ns() const {
    const bool is_apb2 = name() == "USART1" || name() == "USART6";
    const uint64_t bus_hz = is_apb2 ? chip_.clocks().apb2_hz : chip_.clocks().apb1_hz;
    const uint64_t rate = at(kRate);
    // In sixteenths of a bit, or in eighths with a gap of a bit (30.3.4).
    const uint64_t clocks = has(kControl1, kEightfold) ? rate / 16 * 8 + rate % 8 : rate;
    return clocks * kBitsOfByte * 1'000'000'000ULL / bus_hz;
}

// Of bytes that DMA moves, the processor sees the stream's end and the pause behind them.
uint64_t Usart::visible_ns() const {
    const auto between = [&](bool is_to_peripheral) -> uint64_t {
        const uint32_t left = std::max(chip_.dma(1).items_left(*this, is_to_peripheral),
                                       chip_.dma(2).items_left(*this, is_to_peripheral));
        return left > 1 ? left - 1 : 0;
    };
    uint64_t sent_ns = sent_ns_;
    if (sent_ns != kNever && !has(kControl1, kRoom | kComplete)) {
        sent_ns += between(true) * byte_ns();
    }
    uint64_t received_ns = received_ns_;
    if (received_ns != kNever && has(kControl3, kReceiveDma) && !has(kControl1, kReceived)) {
        received_ns += std::min<uint64_t>(arriving_.size(), between(false)) * byte_ns();
    }
    return std::min(sent_ns, received_ns);
}

uint32_t Usart::on_read(uint32_t offset) {
    const uint32_t value = at(offset);
    if (offset == kStatus) {
        seen_ = value;
    } else if (offset == kData) {
        // Errors go with a read of SR and then of DR (30.6.1).
        at(kStatus) &= ~(kReceived | (seen_ & (kOverrun | kIdle | 0x7)));
        seen_ = 0;
        update();
    }
    return value;
}

void Usart::on_write(uint32_t offset, uint32_t value) {
    check(offset, value);
    if (offset == kStatus) {
        at(kStatus) &= value | ~(kReceived | kComplete);  // cleared by writing 0
    } else if (offset == kData) {
        send(static_cast<uint8_t>(value));
    } else {
        at(offset) = value;
    }
    load();
    if (!arriving_.empty() && received_ns_ == kNever) arrive({});
    update();
    chip_.serve_dma();
}

void Usart::check(uint32_t offset, uint32_t value) const {
    const bool changes = value != at(offset);
    if (offset == kRate && changes && (shifting_ || received_ns_ != kNever)) {
        refuse("BRR changes while a byte is on the line");
    }
    if (offset == kRate && value < 16) refuse("BRR is below 16 (30.3.4)");
    if (offset == kControl1 && (value & kEnable) != 0 && at(kRate) == 0) {
        refuse("enabled without a rate");
    }
    const uint32_t control = offset == kControl1 ? value : at(kControl1);
    const uint32_t rate = offset == kRate ? value : at(kRate);
    if ((control & kEightfold) != 0 && (rate & 8) != 0) {
        refuse("BRR has bit 3 with eightfold sampling (30.6.3)");
    }
    // 9 bits, parity, break, mute
    if (offset == kControl1 && (value & 0x1703) != 0) refuse("CR1 is not modelled: " + hex(value));
    if (offset == kControl2 && value != 0) refuse("CR2 is not modelled: " + hex(value));
    if (offset == kControl3 && (value & 0x0F3E) != 0) refuse("CR3 is not modelled: " + hex(value));
}

void Usart::send(uint8_t byte) {
    if (!has(kControl1, kEnable) || !has(kControl1, kSends))
        refuse("DR is written while it is off");
    if (!has(kStatus, kRoom)) refuse("DR is written before the last byte has left it");
    if ((seen_ & kComplete) != 0) at(kStatus) &= ~kComplete;
    waiting_ = byte;
    at(kStatus) &= ~kRoom;
}

void Usart::load() {
    if (shifting_ || !waiting_ || !has(kControl1, kEnable)) return;
    shifting_ = waiting_;
    waiting_.reset();
    at(kStatus) = (at(kStatus) | kRoom) & ~kComplete;
    sent_ns_ = chip_.now_ns() + byte_ns();
}

void Usart::arrive(std::span<const uint8_t> bytes) {
    arriving_.insert(arriving_.end(), bytes.begin(), bytes.end());
    const bool is_on = has(kControl1, kEnable) && has(kControl1, kReceives);
    if (!is_on) {
        arriving_.clear();  // no one listens
    } else if (received_ns_ == kNever && !arriving_.empty()) {
        received_ns_ = chip_.now_ns() + byte_ns();
    }
}

void Usart::run() {
    if (sent_ns_ <= chip_.now_ns()) {
        sent_ns_ = kNever;
        const uint8_t byte = *shifting_;
        shifting_.reset();
        load();
        if (!shifting_) at(kStatus) |= kComplete;
        if (watcher_) watcher_(byte);
    }
    if (received_ns_ <= chip_.now_ns()) receive();
    update();
    chip_.serve_dma();
}

void Usart::receive() {
    received_ns_ = kNever;
    if (arriving_.empty()) {
        at(kStatus) |= kIdle;
        return;
    }
    if (has(kStatus, kReceived)) {
        at(kStatus) |= kOverrun;  // the new byte is lost: 30.3.3
    } else {
        at(kData) = arriving_.front();
        at(kStatus) |= kReceived;
    }
    arriving_.pop_front();
    received_ns_ = chip_.now_ns() + byte_ns();  // the next byte, or the line is idle
}

void Usart::update() {
    const uint32_t control = at(kControl1);
    const uint32_t status = at(kStatus);
    bool is_raised = (status & control & (kIdle | kReceived | kComplete | kRoom)) != 0;
    is_raised |= has(kControl1, kReceived) && (status & kOverrun) != 0;
    is_raised |=
        has(kControl3, kErrorInterrupt) && has(kControl3, kReceiveDma) && (status & 0xE) != 0;
    chip_.set_line(line_, is_raised && (control & kEnable) != 0);
}

}  // namespace stator::chip
