// Core registers of an ARMv7-M processor, with their sections of the ARMv7-M Architecture Reference
// Manual (DDI 0403E).
#pragma once

#include <cstdint>

namespace stator {

// A 32-bit register. Accesses are neither dropped nor merged, and keep their order among each
// other.
class Register {
  public:
    explicit constexpr Register(uint32_t address) : address_(address) {}
    uint32_t read() const { return *pointer(); }
    void write(uint32_t value) const { *pointer() = value; }
    void set(uint32_t bits) const { write(read() | bits); }
    void clear(uint32_t bits) const { write(read() & ~bits); }

  private:
    volatile uint32_t* pointer() const { return reinterpret_cast<volatile uint32_t*>(address_); }
    uint32_t address_;
};

// B3.4: nested vectored interrupt controller. One bit a vector, 32 in a word.
namespace nvic {
constexpr Register set_enable(uint32_t word) {
    return Register(0xE000E100U + 4 * word);
}
constexpr Register set_pending(uint32_t word) {
    return Register(0xE000E200U + 4 * word);
}
constexpr Register clear_pending(uint32_t word) {
    return Register(0xE000E280U + 4 * word);
}
constexpr Register active(uint32_t word) {
    return Register(0xE000E300U + 4 * word);
}
// One byte a vector; only byte writes of one vector are wanted, so no Register.
inline volatile uint8_t& priority(uint32_t vector) {
    return *reinterpret_cast<volatile uint8_t*>(0xE000E400U + vector);
}
}  // namespace nvic

// B3.3: SysTick, 24 bits down to 0.
namespace systick {
inline constexpr Register kControl(0xE000E010);
inline constexpr Register kReload(0xE000E014);
inline constexpr Register kCurrent(0xE000E018);  // any write clears it, so that it reloads
inline constexpr uint32_t kEnable = 1U << 0;
inline constexpr uint32_t kInterrupt = 1U << 1;
inline constexpr uint32_t kCoreClock = 1U << 2;
inline constexpr uint32_t kMaxTicks = 0x00FFFFFF;
}  // namespace systick

// B3.2: system control block.
namespace scb {
inline constexpr Register kVectorTable(0xE000ED08);
inline constexpr Register kResetControl(0xE000ED0C);
inline constexpr uint32_t kResetRequest = 0x05FA0004;  // VECTKEY, SYSRESETREQ
inline constexpr Register kConfiguration(0xE000ED14);
inline constexpr uint32_t kDivideByZeroFaults = 1U << 4;
inline constexpr Register kSystickPriority(0xE000ED20);  // SHPR3: bits 31 to 24
inline constexpr unsigned kSystickPriorityShift = 24;
inline constexpr Register kHandlers(0xE000ED24);
inline constexpr uint32_t kFaultHandlers = 7U
                                           << 16;  // MemManage, BusFault, UsageFault of their own
inline constexpr Register kFaultStatus(0xE000ED28);
inline constexpr Register kHardFaultStatus(0xE000ED2C);
inline constexpr Register kMemoryFaultAddress(0xE000ED34);
inline constexpr Register kBusFaultAddress(0xE000ED38);
inline constexpr Register kCoprocessors(0xE000ED88);
inline constexpr uint32_t kFpuFullAccess = 0xFU << 20;
}  // namespace scb

// C1.8: the counter of the core's cycles.
namespace cycles {
inline constexpr Register kDebugControl(0xE000EDFC);  // DEMCR
inline constexpr uint32_t kTrace = 1U << 24;
inline constexpr Register kControl(0xE0001000);
inline constexpr uint32_t kEnable = 1U << 0;
inline constexpr Register kCount(0xE0001004);
}  // namespace cycles

// B3.5: memory protection unit.
namespace mpu {
inline constexpr Register kControl(0xE000ED94);
inline constexpr uint32_t kEnable = 1U << 0;
inline constexpr uint32_t kDefaultMap = 1U << 2;  // where no region says otherwise
inline constexpr Register kRegion(0xE000ED98);
inline constexpr Register kBase(0xE000ED9C);
inline constexpr Register kAttributes(0xE000EDA0);
}  // namespace mpu

// B3.2.21: how exceptions save the floating-point registers.
namespace fpu {
inline constexpr Register kContextControl(0xE000EF34);
inline constexpr uint32_t kAutomaticSave = 1U << 31;
inline constexpr uint32_t kLazySave = 1U << 30;
}  // namespace fpu

inline void barrier() {
    asm volatile("dsb\n\tisb" ::: "memory");
}

}  // namespace stator
