# %% [markdown]
# **1.** What is the tangent by uniform steps? It is exact, too, of what is computed: the slope of
# one piece of that curve, and of the other sign. Reach **-0.027** J/rad.

# %%
answer = tangent(locate=False)

# %% [markdown]
# **2.** By uniform steps the difference quotients of the figure are small or far too large. How far
# apart are the largest and the smallest of them? Reach **24.0** J/rad.

# %%
answer = np.ptp(np.diff(uniform) / np.diff(tilts))

# %% [markdown]
# **3.** Do shorter steps cure this? Take 1 ms, and the tilts 9.9, 9.92, ... 10.1 mrad. How far
# apart are the quotients now? The jumps are lower, and there are more of them. Reach **8.6** J/rad.

# %%
near = np.linspace(0.0099, 0.0101, 11)
short = np.array([energy(angle, locate=False, dt=1e-3) for angle in near])
answer = np.ptp(np.diff(short) / np.diff(near))
