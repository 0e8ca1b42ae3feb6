#include "piste/condition/time_sync.h"
