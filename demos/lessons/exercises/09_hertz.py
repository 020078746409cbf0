# %% [markdown]
# **1.** How large is the mean pressure over what touches, as a share of its peak? Of a half ellipse
# it is $\pi/4$. Reach **0.8**.

# %%
load = np.linalg.norm(contact.force.sum(axis=0))
answer = load / (2 * half_width) / peak

# %% [markdown]
# **2.** Half the elements: by how many per cent is the peak off now? Reach **0.5**.

# %%
coarse, _, top = compare(press(0.058, n=5)[0])
answer = 100 * abs(top / coarse.peak_pressure - 1)

# %% [markdown]
# **3.** Press half as deep. By Hertz the half width is in proportion to the root of the load. By
# which factor has the load fallen? It is not in proportion to the depth. Reach **2.1**.

# %%
light = press(0.029)[0]
answer = contact.force[:, 1].sum() / light.force[:, 1].sum()
