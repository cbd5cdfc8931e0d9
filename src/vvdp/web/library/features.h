#pragma once
#ifndef hidden
#define hidden
#endif
