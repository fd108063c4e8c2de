/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* One access, neither torn nor repeated, to memory that others access at the same time. */
#ifndef MLCCA_ONCE_BPF_H
#define MLCCA_ONCE_BPF_H

#define READ_ONCE(x)	 (*(const volatile typeof(x) *)&(x))
#define WRITE_ONCE(x, v) (*(volatile typeof(x) *)&(x) = (v))

#endif
