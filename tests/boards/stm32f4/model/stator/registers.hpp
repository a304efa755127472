// Stands in for the chip's registers in tests: a register is a word of a model, which can react to
// reads and writes as the manual says the hardware does.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

namespace stator {

class RegisterModel {
  public:
    std::map<uint32_t, uint32_t> words;
    std::vector<std::pair<uint32_t, uint32_t>> writes;  // address and value, in order
    std::map<uint32_t, std::function<void(uint32_t)>> on_write;
    std::map<uint32_t, std::function<uint32_t()>> on_read;
    std::function<void()> on_barrier = [] {};
    uint64_t reads = 0;

    // One at a time; the newest counts.
    RegisterModel() { current = this; }
    ~RegisterModel() { current = nullptr; }
    RegisterModel(const RegisterModel&) = delete;
    RegisterModel& operator=(const RegisterModel&) = delete;

    inline static RegisterModel* current = nullptr;
};

class Register {
  public:
    explicit constexpr Register(uint32_t address) : address_(address) {}
    uint32_t read() const {
        RegisterModel& model = *RegisterModel::current;
        ++model.reads;
        const auto reaction = model.on_read.find(address_);
        return reaction == model.on_read.end() ? model.words[address_] : reaction->second();
    }
    void write(uint32_t value) const {
        RegisterModel& model = *RegisterModel::current;
        model.words[address_] = value;
        model.writes.emplace_back(address_, value);
        const auto reaction = model.on_write.find(address_);
        if (reaction != model.on_write.end()) reaction->second(value);
    }
    void set(uint32_t bits) const { write(read() | bits); }
    void clear(uint32_t bits) const { write(read() & ~bits); }

  private:
    uint32_t address_;
};

inline void barrier() {
    RegisterModel::current->on_barrier();
}

}  // namespace stator
