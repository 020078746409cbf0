# %% [markdown]
# **1.** How much farther does it come for a little more speed? Differences of `rest` with $v_0$ 1 %
# more and less; exactly $v_0/\mu g$, 0.5097 s. Reach **0.51** s.

# %%
v0 = 2.02
more = rest()
v0 = 1.98
less = rest()
v0 = 2.0
answer = (more - less) / 0.04

# %% [markdown]
# **2.** By uniform steps the difference quotients of the figure are not 0.4. How far apart are the
# largest and the smallest of them? Reach **0.97**.

# %%
answer = np.ptp(np.diff(uniform) / np.diff(heights))

# %% [markdown]
# **3.** Do shorter steps cure this? Take 5 ms, and the heights 0.090, 0.091, ... 0.100 m. How far
# apart are the quotients now? Here they do: the law of velocities slows the mass down so that it
# arrives by the end of the step, and nothing is left of the rounding. Do not count on it. Reach
# **0.000**.

# %%
near = np.linspace(0.09, 0.10, 11)
short = np.array([rest(height, locate=False, dt=0.005) for height in near])
answer = np.ptp(np.diff(short) / np.diff(near))
