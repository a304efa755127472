#include "chip/dma.hpp"

#include <array>

#include "chip/chip.hpp"

namespace stator::chip {

namespace {

constexpr uint32_t kStatus = 0x00, kClear = 0x08, kFirst = 0x10, kStride = 0x18;
// Of a stream
constexpr uint32_t kControl = 0x00, kItems = 0x04, kPeripheral = 0x08, kMemory = 0x0C, kFifo = 0x14;
constexpr uint32_t kEnable = 1U << 0, kDirectionToPeripheral = 1U << 6, kCircular = 1U << 8,
                   kPeripheralIncrement = 1U << 9, kMemoryIncrement = 1U << 10,
                   kDoubleBuffer = 1U << 18, kTransferComplete = 1U << 5, kHalf = 1U << 4;
constexpr uint32_t kFlagBits = 0x3D;
// DMA_SxCR has the interrupts' bits one place lower than the flags, and FEIE in DMA_SxFCR.
constexpr uint32_t kInterrupts = 0x1E;

constexpr uint32_t kAllFlags = kFlagBits * (1U | 1U << 6 | 1U << 16 | 1U << 22);

constexpr Row stream_row(unsigned stream, uint32_t offset, const char* name, uint32_t reset,
                         uint32_t writable, uint32_t read_only = 0) {
    return {kFirst + kStride * stream + offset, name, reset, writable, read_only};
}
constexpr auto rows() {
    std::array<Row, 4 + 6 * 8> rows{{{0x00, "LISR", 0, 0, kAllFlags},
                                     {0x04, "HISR", 0, 0, kAllFlags},
                                     {0x08, "LIFCR", 0, kAllFlags},
                                     {0x0C, "HIFCR", 0, kAllFlags}}};
    for (unsigned stream = 0; stream < 8; ++stream) {
        Row* row = &rows[4 + 6 * stream];
        row[0] = stream_row(stream, kControl, "SxCR", 0, 0x0FEFFFFF);
        row[1] = stream_row(stream, kItems, "SxNDTR", 0, 0xFFFF);
        row[2] = stream_row(stream, kPeripheral, "SxPAR", 0, 0xFFFFFFFF);
        row[3] = stream_row(stream, kMemory, "SxM0AR", 0, 0xFFFFFFFF);
        row[4] = stream_row(stream, 0x10, "SxM1AR", 0, 0xFFFFFFFF);
        row[5] = stream_row(stream, kFifo, "SxFCR", 0x21, 0x00000087, 0x00000038);
    }
    return rows;
}
constexpr auto kRows = rows();

// Interrupt lines of the streams.
constexpr unsigned kLines[2][8] = {{11, 12, 13, 14, 15, 16, 17, 47},
                                   {56, 57, 58, 59, 60, 68, 69, 70}};

unsigned shift_of(unsigned stream) {
    return stream % 4 / 2 * 16 + stream % 2 * 6;
}
uint32_t size_of(uint32_t code) {
    return 1U << code;
}

}  // namespace

Dma::Dma(Chip& chip, unsigned controller)
    : Block(chip, "DMA" + std::to_string(controller), 0x40026000U + 0x400U * (controller - 1),
            0x400, kRows, {0x30, 20 + controller}, kWords),
      controller_(controller) {}

uint32_t Dma::stream_at(unsigned stream, uint32_t offset) const {
    return at(kFirst + kStride * stream + offset);
}

uint32_t Dma::flags_of(unsigned stream) const {
    return at(kStatus + 4 * (stream / 4)) >> shift_of(stream) & kFlagBits;
}

uint32_t Dma::on_read(uint32_t offset) {
    return offset == kClear || offset == kClear + 4 ? 0 : at(offset);
}

void Dma::on_write(uint32_t offset, uint32_t value) {
    if (offset < kClear) return;
    if (offset < kFirst) {
        at(offset - kClear) &= ~value;
        for (unsigned stream = 0; stream < 8; ++stream) update(stream);
        return;
    }
    const unsigned stream = (offset - kFirst) / kStride;
    const uint32_t place = (offset - kFirst) % kStride;
    if (place == kControl) {
        control(stream, value);
        return;
    }
    const bool is_on = (stream_at(stream, kControl) & kEnable) != 0;
    if (is_on) refuse(name_of(offset) + " is written while the stream is enabled (10.5)");
    at(offset) = value;
}

void Dma::control(unsigned stream, uint32_t value) {
    const uint32_t before = stream_at(stream, kControl);
    const bool was_on = (before & kEnable) != 0;
    const bool is_on = (value & kEnable) != 0;
    if (was_on && is_on && ((before ^ value) & ~kInterrupts) != 0) {
        refuse("stream " + std::to_string(stream) + " is configured while it is enabled (10.5.5)");
    }
    at(kFirst + kStride * stream + kControl) = value;
    if (!was_on && is_on) enable(stream, value);
    // A stream that is switched off ends with its flag: 10.3.17.
    if (was_on && !is_on) raise(stream, kTransferComplete);
    update(stream);
    chip_.serve_dma();
}

void Dma::enable(unsigned stream, uint32_t value) {
    const std::string who = "stream " + std::to_string(stream);
    if (flags_of(stream) != 0)
        refuse(who + " is enabled with flags of its last transfer (10.3.17)");
    if ((value >> 6 & 3) > 1) refuse(who + ": memory to memory is not modelled");
    if ((value & kDoubleBuffer) != 0) refuse(who + ": the double buffer is not modelled");
    if ((value & 1U << 5) != 0) refuse(who + ": flow control by the peripheral is not modelled");
    const bool is_direct = (stream_at(stream, kFifo) & 4) == 0;
    if (is_direct && (value >> 21 & 0xF) != 0) refuse(who + ": a burst without FIFO (10.3.12)");
    const uint32_t width = size_of(value >> 11 & 3);
    if (width > 4) refuse(who + ": a reserved size (10.5.5)");
    if (!is_direct && (value >> 13 & 3) != (value >> 11 & 3))
        refuse(who + ": packing is not modelled");
    if (stream_at(stream, kMemory) % width != 0) refuse(who + ": memory address not aligned");
    streams_[stream] = {.items = stream_at(stream, kItems), .moved = 0};
    if (streams_[stream].items == 0) refuse(who + " is enabled with nothing to move");
    const DmaClient* client = client_of(stream);
    if (client == nullptr) refuse(who + ": nothing that is modelled is on its channel");
    if (stream_at(stream, kPeripheral) != client->data_address()) {
        refuse(who + ": expected the address of its peripheral's data, found " +
               hex(stream_at(stream, kPeripheral)));
    }
}

const DmaClient* Dma::client_of(unsigned stream) const {
    const uint32_t control = stream_at(stream, kControl);
    for (const DmaClient* client : clients_) {
        for (const DmaClient::Request& request : client->requests()) {
            if (request.controller == controller_ && request.stream == stream &&
                request.channel == (control >> 25 & 7) &&
                request.is_to_peripheral == ((control & kDirectionToPeripheral) != 0)) {
                return client;
            }
        }
    }
    return nullptr;
}

bool Dma::asks(unsigned stream) const {
    const uint32_t control = stream_at(stream, kControl);
    if ((control & kEnable) == 0) return false;
    return client_of(stream)->asks((control & kDirectionToPeripheral) != 0);
}

uint32_t Dma::items_left(const DmaClient& client, bool is_to_peripheral) const {
    for (unsigned stream = 0; stream < 8; ++stream) {
        const uint32_t control = stream_at(stream, kControl);
        if ((control & kEnable) != 0 && client_of(stream) == &client &&
            ((control & kDirectionToPeripheral) != 0) == is_to_peripheral) {
            return stream_at(stream, kItems);
        }
    }
    return 0;
}

bool Dma::move_item() {
    unsigned chosen = 8;
    for (unsigned stream = 0; stream < 8; ++stream) {
        if (!asks(stream)) continue;
        const auto urgency = [&](unsigned s) { return stream_at(s, kControl) >> 16 & 3; };
        if (chosen == 8 || urgency(stream) > urgency(chosen)) chosen = stream;
    }
    if (chosen == 8) return false;
    transfer(chosen);
    return true;
}

void Dma::transfer(unsigned stream) {
    copy(stream);
    Stream& moving = streams_[stream];
    ++moving.moved;
    uint32_t& left = at(kFirst + kStride * stream + kItems);
    --left;
    if (moving.moved * 2 == moving.items) raise(stream, kHalf);
    if (left != 0) return;
    raise(stream, kTransferComplete);
    uint32_t& control = at(kFirst + kStride * stream + kControl);
    if ((control & kCircular) != 0) {
        left = moving.items;
        moving.moved = 0;
        moving.ahead_bytes = 0;
    } else {
        control &= ~kEnable;
    }
}

void Dma::copy(unsigned stream) {
    const uint32_t control = stream_at(stream, kControl);
    const uint32_t width = size_of(control >> 11 & 3);
    const uint32_t index = streams_[stream].moved * width;
    const uint32_t memory =
        stream_at(stream, kMemory) + ((control & kMemoryIncrement) != 0 ? index : 0);
    if ((control & kPeripheralIncrement) != 0) refuse("PINC with a peripheral's data register");
    const bool is_ram = memory - 0x20000000U < 0x30000U;
    const bool is_flash = memory - 0x08000000U < 0x200000U;
    const bool is_to_peripheral = (control & kDirectionToPeripheral) != 0;
    if (!is_ram && !(is_flash && is_to_peripheral)) {
        refuse("stream " + std::to_string(stream) + " at " + hex(memory) +
               ", which it does not reach (2.1.3)");
    }
    std::array<uint8_t, 4> bytes{};
    const std::span<uint8_t> item(bytes.data(), width);
    if (is_to_peripheral) {
        const uint8_t* fetched = fetch(stream, memory, width);
        uint32_t value = 0;
        for (unsigned i = 0; i < width; ++i) value |= static_cast<uint32_t>(fetched[i]) << 8 * i;
        chip_.write(stream_at(stream, kPeripheral), value, 4);
    } else {
        const uint32_t value = chip_.read(stream_at(stream, kPeripheral), 4);
        for (unsigned i = 0; i < width; ++i) bytes[i] = static_cast<uint8_t>(value >> 8 * i);
        chip_.memory().store(memory, item);
    }
}

// Several items at once, as each question to the memory's owner takes time: firmware must not write
// what a stream has yet to fetch.
const uint8_t* Dma::fetch(unsigned stream, uint32_t memory, uint32_t width) {
    Stream& moving = streams_[stream];
    const bool is_increasing = (stream_at(stream, kControl) & kMemoryIncrement) != 0;
    if (!is_increasing || memory < moving.ahead_from ||
        memory + width > moving.ahead_from + moving.ahead_bytes) {
        const uint32_t left = stream_at(stream, kItems);
        const uint32_t items = is_increasing ? std::min<uint32_t>(left, kAhead / width) : 1;
        moving.ahead_from = memory;
        moving.ahead_bytes = items * width;
        chip_.memory().fetch(memory, std::span(moving.ahead).first(moving.ahead_bytes));
    }
    return &moving.ahead[memory - moving.ahead_from];
}

void Dma::raise(unsigned stream, uint32_t flags) {
    at(kStatus + 4 * (stream / 4)) |= flags << shift_of(stream);
    update(stream);
}

void Dma::update(unsigned stream) {
    const uint32_t enabled =
        (stream_at(stream, kControl) & kInterrupts) << 1 | (stream_at(stream, kFifo) >> 7 & 1);
    chip_.set_line(kLines[controller_ - 1][stream], (flags_of(stream) & enabled) != 0);
}

}  // namespace stator::chip
