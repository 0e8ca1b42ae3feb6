#include "piste/math/interruption.h"

namespace piste {
namespace {

thread_local const std::function<void()>* current = nullptr;

}  // namespace

InterruptedBy::InterruptedBy(const std::function<void()>& check) : before_(current) { current = &check; }
InterruptedBy::~InterruptedBy() { current = before_; }

const std::function<void()>* interruption() { return current; }

void check_interruption() {
  if (current != nullptr) (*current)();
}

}  // namespace piste
